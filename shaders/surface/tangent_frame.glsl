// A model's scale must not weigh normal against tangent: the frame that meets a normal map has the lengths that its vertices
// gave it.
vec3 with_length_of(vec3 before, vec3 after) {
  float length2 = dot(after, after);
  return length2 > 0.0 ? after * sqrt(dot(before, before) / length2) : after;
}
