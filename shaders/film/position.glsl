// Place on the film, in pixels from the image's top left corner, of a sample of `pixel`; `u` in [0,1)^2. The box of one pixel is u itself.
vec2 film_position(uint pixel, vec2 u) {
    vec2 corner = vec2(float(pixel % WIDTH), float(pixel / WIDTH));
#if HAS_FILTER
    vec2 place = vec2(0.5) + vec2(filter_offset(u.x), filter_offset(u.y));
#else
    vec2 place = u;
#endif
    return corner + place;
}
