//! What stands on the terrace. Metres; the board's top is y = 0.03. Spheres (fruit, glass ball, lamp) are in showcase.toml.

use serde_json::json;

use super::glb::Glb;
use super::mesh::{floor, revolve, torus_knot};
use super::pattern;
use super::profile::Profile;

const BOARD_RADIUS: f64 = 0.46;
const BOARD_TOP: f64 = 0.03;

/// The bytes of showcase.glb.
pub fn model() -> Vec<u8> {
    let mut glb = Glb::default();
    terrace(&mut glb);
    metals(&mut glb);
    glass(&mut glb);
    pottery(&mut glb);
    chess(&mut glb);
    glb.finish()
}

/// A quarter turn has sin = cos = 1/sqrt 2: rotation by `degrees` about +y.
fn about_y(degrees: f64) -> [f64; 4] {
    let (sin, cos) = (0.5 * degrees.to_radians()).sin_cos();
    let rounded = |v: f64| (v * 1e6).round() / 1e6;
    [0.0, rounded(sin), 0.0, rounded(cos)]
}

fn terrace(glb: &mut Glb) {
    let (color, roughness, normals) = (
        glb.texture("tiles", &pattern::tiles()),
        glb.texture("tile roughness", &pattern::tile_roughness()),
        glb.texture("tile normals", &pattern::tile_normals()),
    );
    let tiles = glb.material(json!({
        "name": "Tiles",
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": color },
            "metallicRoughnessTexture": { "index": roughness },
            "metallicFactor": 0.0
        },
        "normalTexture": { "index": normals }
    }));
    // 9 m of tiles, 0.24 m each: a texture holds two by two. Lights are chosen by power and the sky's grows with the square of the
    // scene: on a terrace of 24 m the lamp was chosen once in a thousand, and its light came as sparks.
    let shape = glb.shape(&floor(4.5, 18.75).with_uvs());
    let mesh = glb.mesh("terrace", &shape, tiles);
    glb.node("terrace", mesh, [0.04, 0.0, 0.02], about_y(28.0));

    let grain = glb.texture("wood", &pattern::wood());
    let wood = glb.material(json!({
        "name": "Wood",
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": grain }, "metallicFactor": 0.0, "roughnessFactor": 0.38
        }
    }));
    let r = BOARD_RADIUS;
    let profile = Profile::new()
        .curve(&[(r - 0.02, 0.002), (r - 0.004, 0.008), (r, 0.016), (r - 0.003, 0.025), (r - 0.012, BOARD_TOP)], 4)
        .line((r - 0.012, BOARD_TOP), (0.0, BOARD_TOP));
    let mut board = revolve(&profile, 96, 1.0).with_uvs();
    // Sawn from a plank: the grain goes across, not around.
    for (uv, p) in board.uvs.iter_mut().zip(&board.positions) {
        *uv = [0.5 + p[0] * 1.05, 0.5 + p[2] * 1.05 + p[1]];
    }
    let shape = glb.shape(&board);
    let mesh = glb.mesh("board", &shape, wood);
    glb.node("board", mesh, [0.0; 3], about_y(0.0));
}

fn metals(glb: &mut Glb) {
    let gold = glb.material(json!({
        "name": "Gold",
        "pbrMetallicRoughness": { "baseColorFactor": [1.0, 0.73, 0.31, 1.0], "roughnessFactor": 0.28 }
    }));
    let shape = glb.shape(&torus_knot(0.118, 0.0215, 224, 18));
    let mesh = glb.mesh("knot", &shape, gold);
    glb.node("knot", mesh, [0.0, BOARD_TOP + 0.0664, -0.15], about_y(18.0));

    let dents = glb.texture("hammer marks", &pattern::hammered());
    let copper = glb.material(json!({
        "name": "Copper",
        "pbrMetallicRoughness": { "baseColorFactor": [0.93, 0.53, 0.38, 1.0], "roughnessFactor": 0.2 },
        "normalTexture": { "index": dents, "scale": 0.9 }
    }));
    let bowl = Profile::new()
        .line((0.0, 0.0), (0.045, 0.0))
        .curve(&[(0.045, 0.0), (0.083, 0.016), (0.112, 0.044), (0.127, 0.083)], 8)
        .curve(&[(0.127, 0.083), (0.129, 0.0855), (0.1265, 0.087), (0.124, 0.085)], 3)
        .curve(&[(0.124, 0.085), (0.109, 0.047), (0.081, 0.02), (0.04, 0.006), (0.0, 0.004)], 7);
    let shape = glb.shape(&revolve(&bowl, 64, 5.0).with_uvs());
    let mesh = glb.mesh("bowl", &shape, copper);
    glb.node("bowl", mesh, [0.245, BOARD_TOP, -0.05], about_y(0.0));

    let brass = glb.material(json!({
        "name": "Brass",
        "pbrMetallicRoughness": { "baseColorFactor": [0.80, 0.60, 0.30, 1.0], "roughnessFactor": 0.32 }
    }));
    let stand = Profile::new()
        .line((0.0, 0.0), (0.085, 0.0))
        .curve(&[(0.085, 0.0), (0.087, 0.008), (0.07, 0.018), (0.025, 0.028), (0.009, 0.05), (0.0065, 0.09)], 5)
        .curve(&[(0.0065, 0.09), (0.0065, 0.40), (0.010, 0.424), (0.028, 0.436), (0.031, 0.441)], 4)
        .line((0.031, 0.441), (0.0, 0.441));
    let shape = glb.shape(&revolve(&stand, 40, 1.0));
    let mesh = glb.mesh("lamp stand", &shape, brass);
    glb.node("lamp stand", mesh, [0.40, 0.0, -0.47], about_y(0.0));
}

fn glass(glb: &mut Glb) {
    // Thickness 1 says "a solid": the medium is what its surface encloses.
    let glass = glb.material(json!({
        "name": "Glass",
        "pbrMetallicRoughness": { "baseColorFactor": [1.0, 1.0, 1.0, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.0 },
        "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 1.0 },
            "KHR_materials_ior": { "ior": 1.5 },
            "KHR_materials_volume": {
                "thicknessFactor": 1.0, "attenuationDistance": 0.035, "attenuationColor": [0.55, 0.86, 0.74]
            }
        }
    }));
    let tumbler = Profile::new()
        .line((0.0, 0.0), (0.034, 0.0))
        .curve(&[(0.034, 0.0), (0.0385, 0.004), (0.040, 0.012), (0.042, 0.06), (0.0455, 0.122)], 5)
        .curve(&[(0.0455, 0.122), (0.0448, 0.1245), (0.0434, 0.1245), (0.0425, 0.122)], 3)
        .curve(&[(0.0425, 0.122), (0.039, 0.065), (0.0365, 0.028), (0.030, 0.021), (0.0, 0.018)], 5);
    let shape = glb.shape(&revolve(&tumbler, 64, 1.0));
    let mesh = glb.mesh("tumbler", &shape, glass);
    glb.node("tumbler", mesh, [0.118, BOARD_TOP + 0.0005, 0.125], about_y(0.0));
}

fn pottery(glb: &mut Glb) {
    let bands = glb.texture("bands", &pattern::bands());
    let glaze = glb.material(json!({
        "name": "Glaze",
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": bands }, "metallicFactor": 0.0, "roughnessFactor": 0.16
        }
    }));
    let vase = Profile::new()
        .line((0.0, 0.0), (0.047, 0.0))
        .curve(
            &[
                (0.047, 0.0),
                (0.052, 0.010),
                (0.062, 0.05),
                (0.082, 0.105),
                (0.092, 0.16),
                (0.080, 0.215),
                (0.050, 0.255),
                (0.033, 0.285),
                (0.034, 0.315),
                (0.049, 0.345),
            ],
            4,
        )
        .curve(&[(0.049, 0.345), (0.0505, 0.348), (0.0485, 0.349), (0.046, 0.347)], 2)
        .curve(
            &[(0.046, 0.347), (0.030, 0.315), (0.029, 0.285), (0.046, 0.252), (0.074, 0.20), (0.07, 0.12), (0.0, 0.02)],
            3,
        );
    let shape = glb.shape(&revolve(&vase, 56, 1.0).with_uvs());
    let mesh = glb.mesh("vase", &shape, glaze);
    glb.node("vase", mesh, [-0.255, BOARD_TOP, -0.09], about_y(20.0));
}

fn chess(glb: &mut Glb) {
    let stone = |name: &str, color: [f64; 3], roughness: f64| {
        json!({
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [color[0], color[1], color[2], 1.0], "metallicFactor": 0.0, "roughnessFactor": roughness
            }
        })
    };
    let ivory = glb.material(stone("Ivory", [0.80, 0.70, 0.52], 0.35));
    let ebony = glb.material(stone("Ebony", [0.028, 0.020, 0.017], 0.25));
    let foot = |p: Profile, s: f64| {
        p.line((0.0, 0.0), (0.019 * s, 0.0)).curve(
            &[(0.019 * s, 0.0), (0.0205 * s, 0.004), (0.0195 * s, 0.010), (0.0155 * s, 0.013), (0.0145 * s, 0.017)],
            2,
        )
    };
    let pawn = foot(Profile::new(), 1.0)
        .curve(&[(0.0145, 0.017), (0.0095, 0.026), (0.0070, 0.041)], 3)
        .curve(&[(0.0070, 0.041), (0.0118, 0.0435), (0.0118, 0.0455), (0.0065, 0.047)], 2)
        .curve(&[(0.0065, 0.047), (0.0108, 0.053), (0.0112, 0.0595), (0.0075, 0.0675), (0.0, 0.0705)], 4);
    let bishop = foot(Profile::new(), 1.15)
        .curve(&[(0.0167, 0.017), (0.0105, 0.032), (0.0078, 0.060)], 3)
        .curve(&[(0.0078, 0.060), (0.0142, 0.063), (0.0142, 0.0655), (0.0075, 0.068)], 2)
        .curve(&[(0.0075, 0.068), (0.0125, 0.078), (0.0118, 0.091), (0.0055, 0.104), (0.0022, 0.108)], 4)
        .curve(&[(0.0022, 0.108), (0.0045, 0.1115), (0.0035, 0.115), (0.0, 0.1165)], 2);
    let queen = foot(Profile::new(), 1.3)
        .curve(&[(0.01885, 0.017), (0.0115, 0.036), (0.0085, 0.080)], 3)
        .curve(&[(0.0085, 0.080), (0.0155, 0.083), (0.0155, 0.086), (0.0085, 0.089)], 2)
        .curve(&[(0.0085, 0.089), (0.0102, 0.102), (0.0155, 0.120)], 3)
        .curve(&[(0.0155, 0.120), (0.0130, 0.1215), (0.0080, 0.125), (0.0030, 0.127)], 2)
        .curve(&[(0.0030, 0.127), (0.0050, 0.131), (0.0038, 0.135), (0.0, 0.1365)], 2);
    let mut shape = |profile: &Profile| glb.shape(&revolve(profile, 32, 1.0));
    let (pawn, bishop, queen) = (shape(&pawn), shape(&bishop), shape(&queen));
    let pieces = [
        ("ivory queen", &queen, ivory, [-0.235, 0.135]),
        ("ivory bishop", &bishop, ivory, [-0.165, 0.055]),
        ("ivory pawn", &pawn, ivory, [0.005, 0.245]),
        ("ebony pawn", &pawn, ebony, [0.055, 0.315]),
        ("ebony bishop", &bishop, ebony, [0.245, 0.225]),
        ("ebony queen", &queen, ebony, [-0.335, 0.04]),
    ];
    for (name, shape, material, [x, z]) in pieces {
        let mesh = glb.mesh(name, shape, material);
        glb.node(name, mesh, [x, BOARD_TOP, z], about_y(0.0));
    }
}
