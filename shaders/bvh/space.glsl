// The ray in the space that a traversal is in: the world, or that of a placed mesh.

struct RaySpace {
    BoxRay boxes;
#if HAS_TRIANGLES
    TriangleRay sheared;
#endif
#if HAS_INSTANCES
    uint instance;
    uint primitive_offset;
#endif
};

RaySpace world_space(Ray ray) {
    RaySpace space;
    space.boxes = box_ray(ray);
#if HAS_TRIANGLES
    space.sheared = triangle_ray(ray.o, ray.d);
#endif
#if HAS_INSTANCES
    space.instance = 0u;
    space.primitive_offset = 0u;
#endif
    return space;
}

#if HAS_INSTANCES
// Takes the ray of the world into the space that this row of `instances` places; returns the root of the tree there.
uint space_enter(inout RaySpace space, uint row, Ray ray) {
    InstanceRecord placed = InstanceRecord_load_instances(row);
    Ray local = instance_ray(placed, ray);
    space.boxes = box_ray(local);
#if HAS_TRIANGLES
    space.sheared = triangle_ray(local.o, local.d);
#endif
    space.instance = row;
    space.primitive_offset = placed.primitive_offset;
    return placed.first_node;
}
#endif
