// The pixel filter's inverse distribution; see src/film/filter. `u` in [0,1); returns the offset from the pixel's centre in pixels.
// A cell is the numbers w that share exponent and 4 bits of mantissa, and holds a cubic in the place within it.
float filter_offset(float u) {
    float w = clamp(min(u, 1.0 - u), 2.98023223876953125e-8, 0.49999997019767761230);
    uint bits = floatBitsToUint(w);
    vec4 cubic = uintBitsToFloat(filter_cells_row((bits >> FILTER_CELL_SHIFT) - FILTER_FIRST_CELL));
    float t = float(bits & ((1u << FILTER_CELL_SHIFT) - 1u)) / float(1u << FILTER_CELL_SHIFT);
    float magnitude = cubic.x + t * (cubic.y + t * (cubic.z + t * cubic.w));
    return u < 0.5 ? -magnitude : magnitude;
}
