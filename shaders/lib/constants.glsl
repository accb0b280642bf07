const float PI = 3.14159265358979;
const float TWO_PI = 6.28318530717959;
const float INV_PI = 0.318309886183791;
// Below this a cosine is taken as grazing; keeps quotients finite in single precision.
const float MIN_COSINE = 1e-4;
