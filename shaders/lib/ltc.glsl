// Light of polygons on lobes that are linearly transformed cosines: Heitz, Dupuy, Hill and Neubelt 2016, "Real-Time
// Polygonal-Light Shading with Linearly Transformed Cosines".
#include "lib/constants.glsl"

// Lambert 1760, "Photometria": of the vector irradiance of a polygon the part of one edge, along z. `a`, `b`: unit.
float edge_irradiance(vec3 a, vec3 b) {
  vec3 across = cross(a, b);
  float sine = length(across);
  return sine > 1e-7 ? atan(sine, dot(a, b)) / sine * across.z : across.z;
}

// Adds up what a convex polygon above the horizon z = 0 gives, an edge at a time. What the horizon cuts off is closed by an arc
// along it, from where the outline goes down to where it comes up.
struct PolygonSum {
  vec3 last;
  vec3 up, down;
  float irradiance;
};

PolygonSum begin_polygon(vec3 last_corner) { return PolygonSum(last_corner, vec3(0.0), vec3(0.0), 0.0); }

void add_corner(vec3 corner, inout PolygonSum sum) {
  vec3 a = sum.last, b = corner;
  vec3 crossing = a * b.z - b * a.z;  // on the horizon, to either side
  if (a.z < 0.0 && b.z > 0.0) sum.up = a = normalize(crossing);
  if (a.z > 0.0 && b.z < 0.0) sum.down = b = normalize(-crossing);
  if (max(a.z, b.z) > 0.0) sum.irradiance += edge_irradiance(normalize(a), normalize(b));
  sum.last = corner;
}

// The share of the lobe that the polygon takes, [0, 1]; whichever way its corners go round.
float end_polygon(PolygonSum sum) {
  if (sum.up != sum.down) sum.irradiance += edge_irradiance(sum.down, sum.up);
  return abs(sum.irradiance) / TWO_PI;
}
