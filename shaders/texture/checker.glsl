// Checkerboard; see src/texture/checker.rs. `scale` squares a unit of u and of v; `a` where the sum of the two floors is even.
// From |uv scale| = 2^24 on a float is an even integer, which is `a`; so are NaN and infinity.
vec4 texture_checker(vec4 a, vec4 b, vec2 scale, vec2 uv) {
    vec2 square = floor(uv * scale);
    // 0 or 1 each, exact at any size: the sum of the floors would lose its last bit.
    precise vec2 parity = square - 2.0 * floor(0.5 * square);
    return parity.x + parity.y == 1.0 ? b : a;
}
