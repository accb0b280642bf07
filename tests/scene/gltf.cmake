furnace_test(scene_gltf LABEL unit
  SOURCES gltf_accessor_test.cpp gltf_animation_test.cpp gltf_container_test.cpp gltf_corpus_test.cpp gltf_deform_test.cpp gltf_fuzz_test.cpp
    gltf_import_test.cpp gltf_layers_test.cpp gltf_material_test.cpp gltf_models_test.cpp
    gltf_variants_test.cpp
  LINK furnace_decode nlohmann_json::nlohmann_json)
furnace_test(scene_tangents LABEL unit SOURCES tangents_test.cpp LINK furnace_decode)
furnace_test(scene_compression LABEL unit SOURCES draco_test.cpp meshopt_test.cpp
  LINK furnace_decode nlohmann_json::nlohmann_json draco::draco meshoptimizer::meshoptimizer)
furnace_test(model_report_test LABEL unit SOURCES model_report_test.cpp LINK furnace_decode nlohmann_json::nlohmann_json)
furnace_test(scene_models LABEL unit SOURCES model_format_test.cpp model_import_test.cpp obj_test.cpp stl_test.cpp ply_test.cpp polygon_test.cpp text_number_test.cpp
  LINK furnace_decode)
