// The same value everywhere; see src/texture/constant.rs.
vec4 texture_constant(vec4 value) {
    return value;
}
