// One invocation fills one slot: push.block_samples samples at one pixel, those of one block. Paths are regenerated in place: a lane whose path has ended
// begins its next sample in the same iteration, so that lanes of a subgroup stay busy.

// `rays` is how many it took to begin: a meter is served by light sampling at once.
PathState path_begin(uint pixel, uint sample_index, inout Tally tally, out uint rays) {
    PathState s;
    s.id = sample_id(pixel, sample_index, push.seed);
    s.hash = hash_combine(hash_combine(push.seed, pixel), sample_index);
    s.edge = 0u;
    CameraRecord camera = CameraRecord_load_camera(0u);
    vec2 film = film_position(pixel, vec2(u01(path_word(s, PIXEL_X)), u01(path_word(s, PIXEL_Y))));
    CameraRay start = camera_ray(camera, film, s.id);
    s.ray = Ray(start.o, start.d, INFINITY);
    s.throughput = Spectrum(start.weight);
    s.radiance = Spectrum(0.0);
    s.pdf = 0.0;
    s.eta_scale = 1.0;
#if NEXT_EVENT
    s.from = start.o;
    s.from_normal = start.receiver;
#endif
#if MEDIA_STACK
    s.medium = camera.media;
    s.beyond = camera.media;
    s.outside = 1.0;
    s.touching = 0.0;
#elif HAS_MEDIA
    s.medium = camera.medium;
#endif
#if TEXTURE_HAS_MIPS
    s.cone = camera.cone;
#endif
#if AOV_SPLIT
    s.direct = Spectrum(0.0);
#endif
    AOV_START
    rays = 0u;
#if HAS_RECEIVER
    s.pdf = dot(start.d, start.receiver) * INV_PI;
    rays = receive(s, start.receiver, tally);
#endif
    return s;
}

// False once the driver has ended this invocation's loops. lavapipe lets all loops of an invocation together run 65535 times
// (Mesa, LP_MAX_TGSI_LOOP_ITERATIONS); from then on, and without a word, each runs once. The number of passes comes from the
// dispatch, so that no compiler knows the answer.
bool loops_run() {
    uint passes = 0u;
    while (passes < min(push.block_samples, 1u) + 1u) {
        passes += 1u;
    }
    return passes > 1u;
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= push.tile_pixels * push.block_count) {
        return;
    }
#if BY_LIST
    uvec2 job = jobs.rows[slot];
    uint pixel = job.x;
    uint first_sample = job.y * push.block_samples;
#else
    uint in_tile = slot % push.tile_pixels;
    uint x = push.tile_x + in_tile % push.tile_width;
    uint y = push.tile_y + in_tile / push.tile_width;
    uint pixel = y * WIDTH + x;
    uint first_sample = (push.first_block + slot / push.tile_pixels) * push.block_samples;
#endif
    uint last_sample = first_sample + (push.block_samples - 1u);
    uint sample_index = first_sample;
    Tally tally = tally_new();
    Spectrum sum = Spectrum(0.0);
    uint rays;
    PathState state = path_begin(pixel, sample_index, tally, rays);
    tally.rays += rays;
    bool is_running = true;
    while (is_running) {
        bool goes_on = integrator_step(state, tally);
        // A step in which loops were ended is none: its sample does not count, and the host takes it again.
        bool is_whole = loops_run();
        if (!goes_on && is_whole) {
            sum += tally_sample(tally, state, slot, sample_index);
            is_running = sample_index != last_sample;
            sample_index += 1u;
            if (is_running) {
                state = path_begin(pixel, sample_index, tally, rays);
                tally.rays += rays;
            }
        }
        is_running = is_running && is_whole;
    }
    tally.cut = last_sample + 1u - sample_index;
    tally.first_bad = tally.cut != 0u && tally.first_bad == NONE ? sample_index : tally.first_bad;
    slot_write(slot, sum, tally);
}
