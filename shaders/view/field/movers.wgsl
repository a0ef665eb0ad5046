// What has moved. Whoever joins this text names `movers`.

// A thing that has moved: what was seen of it is kept where it was before it ever moved, under its own
// name. Columns are rows: a point (m from the field's origin, 1) times them is the mapped one. Keep in
// sync with src/percept/field/movers.rs.
struct Mover {
    own: mat3x4<f32>,     // into its own frame, where its box is
    rest: mat3x4<f32>,    // to where it was
    center: vec3<f32>,    // of its box
    name: u32,            // from 1
    half_size: vec3<f32>, // of its box
    is_new: u32,          // 1: what was seen of it stands under no name yet
};

struct Movers {
    count: u32,
    unused: vec3<u32>,
    list: array<Mover>,   // smaller ones first
};

// The thing that has moved to where a point is, by its place in the list; their number where there is none.
fn mover_at(point: vec3<f32>) -> u32 {
    for (var k = 0u; k < movers.count; k++) {
        let off = vec4<f32>(point, 1.0) * movers.list[k].own - movers.list[k].center;
        if all(abs(off) <= movers.list[k].half_size) {
            return k;
        }
    }
    return movers.count;
}
