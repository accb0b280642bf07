// What glows of a pixel: its share above the threshold, of the same hue. From half the threshold on it sets in as a parabola
// that meets the straight line at one and a half.
vec3 bright_part(vec3 exposed, float threshold) {
  float peak = max(exposed.r, max(exposed.g, exposed.b));
  float soft = clamp(peak - 0.5 * threshold, 0.0, threshold);
  float above = max(soft * soft / max(2.0 * threshold, 1e-20), peak - threshold);
  return exposed * (above / max(peak, 1e-20));
}
