// Layers: renderer/ibl/dfg.hpp, ltc.hpp, then the lights' profiles.
layout(binding = 7) uniform sampler2DArray lobe_tables;
