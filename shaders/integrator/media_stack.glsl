// The media that a path is in where dielectrics overlap (Schmidt, Budge 2002, "Simple nested dielectrics in ray traced images").
//
// Up to four media that it has entered, the newest last; the one of the highest priority fills the space. An entry is the priority's
// rank << 16 | row of `media` + 1; 0 is none. See src/prepare/media.rs.

// The medium that fills the space: of the highest rank, of equals the newest.
uint media_current(uvec4 m) {
    uint r = m.x;
    r = m.y != 0u && (m.y >> 16) >= (r >> 16) ? m.y : r;
    r = m.z != 0u && (m.z >> 16) >= (r >> 16) ? m.z : r;
    r = m.w != 0u && (m.w >> 16) >= (r >> 16) ? m.w : r;
    return r;
}

// A fifth medium is not remembered.
uvec4 media_enter(uvec4 m, uint entry) {
    uvec4 r = m;
    r.x = m.x == 0u ? entry : m.x;
    r.y = m.x != 0u && m.y == 0u ? entry : m.y;
    r.z = m.y != 0u && m.z == 0u ? entry : m.z;
    r.w = m.z != 0u && m.w == 0u ? entry : m.w;
    return r;
}

// Without the newest of these entries, or without the medium that fills the space where there is none of them.
uvec4 media_leave(uvec4 m, uint entry) {
    uint gone = any(equal(m, uvec4(entry))) ? entry : media_current(m);
    bool at_w = m.w == gone;
    bool at_z = !at_w && m.z == gone;
    bool at_y = !at_w && !at_z && m.y == gone;
    bool at_x = !at_w && !at_z && !at_y && m.x == gone;
    // Those after it move down.
    bool from_y = at_x || at_y;
    bool from_z = from_y || at_z;
    return uvec4(at_x ? m.y : m.x, from_y ? m.z : m.y, from_z ? m.w : m.z, from_z || at_w ? 0u : m.w);
}

uint medium_row(uint entry) {
    return entry == 0u ? NONE : (entry & 0xffffu) - 1u;
}

float medium_eta(uint entry) {
    return entry == 0u ? 1.0 : MediumRecord_load_media(medium_row(entry)).eta;
}

// What entering this material adds to a path's media; 0 for what bounds no medium.
uint medium_entry(MaterialRecord material) {
    bool bounds = (material.flags & MATERIAL_TRANSMITS) != 0u && (material.flags & MATERIAL_THIN) == 0u;
    return bounds && material.interior != NONE ? (material.priority << 16) | (material.interior + 1u) : 0u;
}
