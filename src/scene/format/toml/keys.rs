//! Every section and key a .toml scene may hold: the parser refuses what is not here, and docs/scene.md is generated
//! from here (test below; `STERADIAN_BLESS=1` rewrites the page's tables).

/// One key: its form as a user writes it, what it is when left out, and what it means.
pub struct Key {
    pub name: &'static str,
    pub form: &'static str,
    pub default: &'static str,
    pub doc: &'static str,
}

pub struct Section {
    /// As it stands in the file, for messages and for the page.
    pub name: &'static str,
    pub doc: &'static str,
    pub keys: &'static [Key],
}

/// `name: form = default; doc` rows.
macro_rules! section {
    ($name:literal, $doc:literal, $($key:literal: $form:literal = $default:literal; $text:literal),* $(,)?) => {
        Section {
            name: $name,
            doc: $doc,
            keys: &[$(Key { name: $key, form: $form, default: $default, doc: $text }),*],
        }
    };
}

pub const TOP: Section = section!("top level", "The file itself.",
    "name": "string" = "file name"; "shown in records",
    "camera": "[camera]" = "frames the bounds"; "below",
    "film": "[film]" = "640 x 480"; "below",
    "sky": "[sky]" = "none"; "below; a scene without any light gets a uniform sky of radiance 1",
    "texture": "[[texture]]" = "none"; "below, any number",
    "material": "[[material]]" = "none"; "below, any number; `[material.\"Name\"]` patches what a model brought",
    "light": "[[light]]" = "none"; "below, any number: lights without a surface",
    "shape": "[[shape]]" = "none"; "below, any number",
    "model": "[[model]]" = "none"; "below, any number",
    "sensor": "[[sensor]]" = "none"; "below, any number; what `measure` measures",
    "node": "[node.\"path/name\"]" = "none"; "below; patches a node that a model brought",
);

pub const CAMERA: Section = section!("[camera]", "Without `position` the bounds of the scene are framed.",
    "type": "\"perspective\", \"thin_lens\", \"orthographic\" or \"panorama\"" = "\"perspective\""; "a panorama shows all directions, laid out as a sky's picture",
    "position": "[x, y, z] m" = "framed"; "where it stands",
    "target": "[x, y, z] m" = "[0, 0, 0]"; "the point in the middle of the picture",
    "up": "[x, y, z]" = "[0, 1, 0]"; "not along the view",
    "fov_y_deg": "number in (0, 180)" = "40"; "perspective, thin_lens: vertical field of view",
    "lens_radius": "number >= 0, m" = "0"; "thin_lens: of its opening; 0 is the perspective camera",
    "f_number": "number > 0" = "none"; "thin_lens: instead of `lens_radius`, with `focal_length_mm`: the radius is focal length / (2 f_number)",
    "focal_length_mm": "number > 0, mm" = "none"; "thin_lens: for `f_number`; the field of view is `fov_y_deg` all the same",
    "focus_distance": "number > 0, m" = "to the target"; "thin_lens: of the plane in focus, along the view",
    "height": "number > 0, m" = "2, or framed"; "orthographic: of what is seen; the width follows from the film's shape",
);

pub const FILM: Section = section!("[film]", "Flags of the command line win over these.",
    "size": "[width, height] pixels" = "[640, 480]"; "each 1..=65536",
    "crop": "[x0, y0, x1, y1] pixels" = "the whole image"; "only columns x0..x1 and rows y0..y1 are rendered, x1 and y1 excluded, each as in the whole image",
    "filter": "\"box\", \"gaussian\" or \"blackman-harris\"" = "\"box\""; "pixel filter, drawn from, so that samples weigh the same; gaussian is cut at 3 standard deviations",
    "filter_radius": "number in (0, 32], pixels" = "box 0.5, others 1.5"; "where the filter ends; a box of 0.5 is the pixel itself",
    "shutter_s": "number > 0, s" = "none"; "with `iso` and `f_number`: exposes .png files, white being what saturates a film of ISO 12232",
    "iso": "number > 0" = "none"; "speed of the film",
    "f_number": "number > 0" = "none"; "focal length over the aperture's diameter; only exposure follows from it",
    "spp": "integer" = "256"; "samples a pixel when no stop is given",
    "max_depth": "integer" = "4096"; "path edges: 1 = emission seen directly, 2 = one bounce",
    "texture_filter": "\"exact\" or \"mipmap\"" = "\"exact\""; "exact: pixels are averaged by samples; mipmap: textures that are seen small are read as means over the ray's footprint, with less noise and a bias",
);

pub const SKY: Section = section!("[sky]", "Light from infinitely far away: `file` or `radiance`.",
    "file": "path (.hdr, .exr)" = "none"; "lat-long image; its centre is -z, its right half +x; NaN, infinite and negative values become 0",
    "unit": "\"radiance\" or \"nt\"" = "\"radiance\""; "of the pixels of `file`: W/(m2 sr), or cd/m2",
    "radiance": "number or [r, g, b] W/(m2 sr)" = "none"; "the same from everywhere",
    "radiance_nt": "number, cd/m2" = "none"; "the same in nits",
    "rotate_deg": "number" = "0"; "turns it about +y",
    "scale": "number >= 0" = "1"; "factor on the radiance",
    "illuminance_lx": "number, lx" = "none"; "instead of `scale`: what a horizontal plane without anything above it gets",
    "group": "name" = "\"default\""; "its light group, 1 to 32 letters, digits, _ or -: `--aov light_groups` keeps the light of each apart (docs/film.md)",
);

pub const LIGHT: Section = section!("[[light]]", "A light without a surface. Exactly one of its keys in W, lm, cd, lx says how strong it is. A number keeps its luminance (683 lm a watt) whatever the colour; a triple is taken channel by channel.",
    "type": "\"point\", \"spot\" or \"directional\"" = "required"; "kind",
    "name": "string" = "the type"; "for messages",
    "group": "name" = "\"default\""; "its light group, 1 to 32 letters, digits, _ or -: `--aov light_groups` keeps the light of each apart (docs/film.md)",
    "color": "[r, g, b]" = "white"; "linear; its luminance is divided out",
    "temperature_k": "number in 500..100000, K" = "none"; "instead of `color`: that of a black body",
);

pub const POINT: Section = section!("[[light]] type = \"point\"", "The same intensity everywhere: I = power / 4 pi, and a surface gets I cos / d^2.",
    "position": "[x, y, z] m" = "required"; "where it stands",
    "power": "number or [r, g, b], W" = "none"; "of the whole light",
    "power_lm": "number, lm" = "none"; "the same in lumens",
    "intensity": "number or [r, g, b], W/sr" = "none"; "",
    "intensity_cd": "number, cd" = "none"; "the same in candelas",
);

pub const SPOT: Section = section!("[[light]] type = \"spot\"", "Brightest on its axis. `hard`: the same inside the cone and nothing outside. `cosine`: cos^exponent on the front half. `smooth`: t^2 with t = (cos - cos cone)/(cos inner - cos cone) within [0, 1], as in glTF. `power` is what leaves it, `intensity` that on the axis.",
    "position": "[x, y, z] m" = "required"; "where it stands",
    "direction": "[x, y, z]" = "required"; "the way its light goes",
    "target": "[x, y, z] m" = "none"; "instead of `direction`: a point on the axis",
    "falloff": "\"hard\", \"cosine\" or \"smooth\"" = "\"smooth\""; "as above",
    "cone_deg": "number in (0, 180]" = "required for hard and smooth"; "angle from the axis beyond which it is dark",
    "inner_cone_deg": "number in [0, cone_deg)" = "0"; "smooth: angle up to which it is brightest",
    "exponent": "number in 0..10000" = "1"; "cosine",
    "power": "number or [r, g, b], W" = "none"; "of the whole light",
    "power_lm": "number, lm" = "none"; "the same in lumens",
    "intensity": "number or [r, g, b], W/sr" = "none"; "on the axis",
    "intensity_cd": "number, cd" = "none"; "the same in candelas",
);

pub const DIRECTIONAL: Section = section!("[[light]] type = \"directional\"", "Parallel light from infinitely far away; with a diameter a disc of uniform radiance, which the camera sees too.",
    "direction": "[x, y, z]" = "required"; "the way its light goes",
    "irradiance": "number or [r, g, b], W/m2" = "none"; "on a plane across it",
    "irradiance_lx": "number, lx" = "none"; "the same in lux",
    "angular_diameter_deg": "number in 0..180" = "0"; "the Sun's is 0.533",
);

pub const TEXTURE: Section = section!("[[texture]]", "A picture or pattern that material inputs look up by name.",
    "name": "string" = "required"; "what inputs refer to",
    "type": "\"image\", \"checker\" or \"constant\"" = "\"image\""; "kind",
    "file": "path (.png, .jpg, .webp, .hdr, .exr)" = "required for image"; "beside the scene file; 8 or 16 bits a channel, .hdr and .exr linear",
    "wrap": "\"repeat\", \"mirror\", \"clamp\", or two of them" = "\"repeat\""; "image: outside [0,1] in u and v",
    "filter": "\"linear\" or \"nearest\"" = "\"linear\""; "image",
    "mipmap": "\"linear\", \"nearest\" or \"none\"" = "\"linear\""; "image: between levels, where `texture_filter` of [film] is \"mipmap\"",
    "encoding": "\"srgb\" or \"linear\"" = "\"srgb\""; "image: how its bytes become linear; normal maps and roughness are \"linear\"",
    "a": "colour" = "[0.8, 0.8, 0.8]"; "checker: squares where floor(u s) + floor(v s) is even",
    "b": "colour" = "[0.2, 0.2, 0.2]"; "checker: the others",
    "squares": "number or [u, v]" = "8"; "checker: squares a unit of u and v",
    "color": "colour" = "required for constant"; "constant",
);

pub const MATERIAL: Section = section!("[[material]]", "A surface. Its other keys are the inputs of its `type`, listed further below.",
    "name": "string" = "required"; "what shapes refer to",
    "type": "keyword of a model, or \"mix\"" = "\"lambert\""; "listed further below; in a patch it replaces the model and all inputs",
    "materials": "list of names" = "required for mix"; "mix: two or more [[material]]s written before",
    "factor": "value in [0, 1]" = "required for mix"; "mix: share of the second of two materials",
    "weights": "list of numbers >= 0" = "none"; "mix: instead of `factor`, one a material; divided by their sum",
    "emission": "value, W/(m2 sr)" = "none"; "radiance it emits, linear RGB; at most 1e18, as all lights",
    "emission_nt": "value, cd/m2" = "none"; "the same in nits: luminance 683 Y of the radiance",
    "emission_two_sided": "boolean" = "false"; "emits on the back too",
    "group": "name" = "\"default\""; "light group of what it emits (docs/film.md)",
    "alpha": "value in [0, 1]" = "1"; "presence: how likely a ray meets the surface",
    "alpha_cutoff": "number in [0, 1]" = "none"; "with it the surface is there exactly where alpha >= cutoff",
    "normal_map": "{ texture = \"name\", strength = 1, ... }" = "none"; "tangent-space normals, x and y times strength",
    "absorption": "number or [r, g, b], 1/m" = "none"; "of the medium behind a refracting surface (Beer-Lambert), at most 1e20",
    "priority": "integer" = "0"; "where bodies that refract overlap, the higher fills the space; of equals the one entered last",
);

pub const VALUE: Section = section!("value", "An input is a number, a colour `[r, g, b]` or `[r, g, b, a]` (linear), or a table of these keys.",
    "texture": "string" = "none"; "name of a `[[texture]]`",
    "uv_set": "0 or 1" = "0"; "which texture coordinates",
    "scale": "number or [u, v]" = "1"; "uv becomes offset + rotate(scale * uv), as in KHR_texture_transform",
    "offset": "[u, v]" = "[0, 0]"; "",
    "rotate_deg": "number" = "0"; "",
    "channel": "\"r\", \"g\", \"b\" or \"a\"" = "all"; "take one channel for all",
    "vertex_color": "true" = "false"; "the mesh's colour; white where it has none",
    "factor": "number or colour" = "1"; "multiplies the result",
    "metal": "\"gold\", \"copper\" or \"aluminium\"" = "none"; "for `eta` and `k`: the metal's complex index",
    "curve": "[[nm, value], ...]" = "none"; "a measured quantity against wavelength, such as `eta` and `k` of a metal",
    "strength": "number" = "1"; "for `normal_map` only",
);

pub const SHAPE: Section = section!("[[shape]]", "Something to see. All kinds share these keys; a shape is scaled, then turned, then moved.",
    "type": "\"sphere\", \"disc\", \"rectangle\", \"box\" or \"mesh\"" = "required"; "kind",
    "name": "string" = "the type"; "for messages and patches",
    "material": "string" = "grey lambert"; "name of a `[[material]]`",
    "power": "number or [r, g, b], W" = "none"; "makes it a lamp that emits so much in all, in the colour of its material's emission; not with textures",
    "power_lm": "number, lm" = "none"; "the same in lumens",
    "group": "name" = "its material's"; "light group of what it emits; on a shape that shines",
    "scale": "number or [x, y, z]" = "1"; "spheres take one number, discs one for both directions in their plane",
    "rotate_deg": "[x, y, z] or number" = "0"; "about x, then y, then z; one number with `rotate_axis`",
    "rotate_axis": "[x, y, z]" = "none"; "axis of a single turn, counter-clockwise",
    "translate": "[x, y, z] m" = "[0, 0, 0]"; "",
    "matrix": "16 numbers" = "none"; "instead of the four above: object to world, row by row, last row 0 0 0 1",
    "copies": "[{ translate = [...], ... }, ...]" = "one, where it is"; "stands once for each, its own placement first, then the copy's; all share one mesh",
    "copies_file": "path" = "none"; "the same from a text file of 12 numbers a line: the first three rows of object to world",
);

pub const SPHERE: Section = section!("[[shape]] type = \"sphere\"", "Analytic. Its front is outside.",
    "center": "[x, y, z] m" = "[0, 0, 0]"; "",
    "radius": "number > 0, m" = "1"; "",
);

pub const DISC: Section = section!("[[shape]] type = \"disc\"", "Analytic and flat. Its front is the side that `normal` points to; texture [0,1]^2 is the square around it, u along x and v against y of a disc that faces +z, turned with it the shortest way.",
    "center": "[x, y, z] m" = "[0, 0, 0]"; "",
    "normal": "[x, y, z]" = "[0, 0, 1]"; "any length but 0",
    "radius": "number > 0, m" = "1"; "",
);

pub const RECTANGLE: Section = section!("[[shape]] type = \"rectangle\"", "center +- u +- v; its front is the side of u x v. Texture u runs along u, v against v.",
    "center": "[x, y, z] m" = "[0, 0, 0]"; "",
    "u": "[x, y, z] m" = "[1, 0, 0]"; "half of one side",
    "v": "[x, y, z] m" = "[0, 1, 0]"; "half of the other",
);

pub const BOX: Section = section!("[[shape]] type = \"box\"", "Twelve triangles, front outside; each face spans texture [0,1]^2.",
    "min": "[x, y, z] m" = "[-1, -1, -1]"; "lowest corner",
    "max": "[x, y, z] m" = "[1, 1, 1]"; "highest corner",
);

pub const MESH: Section = section!("[[shape]] type = \"mesh\"", "Triangles written out, or from a file; the front of each is where its corners run counter-clockwise.",
    "file": "path (.obj, .ply)" = "none"; "instead of all keys below: the shapes of a file without its materials",
    "positions": "[[x, y, z], ...] m" = "required"; "one a vertex",
    "triangles": "[[a, b, c], ...]" = "required"; "vertex numbers from 0",
    "normals": "[[x, y, z], ...]" = "flat"; "one a vertex",
    "uvs": "[[u, v], ...]" = "none"; "one a vertex; v runs down the picture",
    "uvs1": "[[u, v], ...]" = "none"; "the second set",
    "colors": "[[r, g, b], ...]" = "none"; "one a vertex, linear; or [r, g, b, a]",
);

pub const MODEL: Section = section!("[[model]]", "A .gltf, .glb, .obj or .ply file. A glTF file's camera is used when the scene has no `[camera]`.",
    "file": "path" = "required"; "beside the scene file",
    "variant": "string" = "its own materials"; "name of a material variant (KHR_materials_variants)",
    "scene": "integer" = "its default"; "number of the scene in the file, from 0",
    "scale": "number or [x, y, z]" = "1"; "as for shapes",
    "rotate_deg": "[x, y, z] or number" = "0"; "as for shapes",
    "rotate_axis": "[x, y, z]" = "none"; "as for shapes",
    "translate": "[x, y, z] m" = "[0, 0, 0]"; "as for shapes",
    "light_scale": "number >= 0" = "1"; "factor on its lights (KHR_lights_punctual, cd and lx over 683); many files hold numbers for viewers that take lux for W/m2: 683 takes them so",
    "matrix": "16 numbers" = "none"; "as for shapes",
    "copies": "[{ translate = [...], ... }, ...]" = "one, where it is"; "as for shapes",
    "copies_file": "path" = "none"; "as for shapes",
    "group": "name" = "none"; "light group of all its lights and of its materials that shine",
);

pub const COPY: Section = section!("copy", "One entry of `copies`, of a shape or a model: scaled, then turned, then moved.",
    "scale": "number or [x, y, z]" = "1"; "as for shapes; negative numbers mirror",
    "rotate_deg": "[x, y, z] or number" = "0"; "as for shapes",
    "rotate_axis": "[x, y, z]" = "none"; "as for shapes",
    "translate": "[x, y, z] m" = "[0, 0, 0]"; "as for shapes",
    "matrix": "16 numbers" = "none"; "as for shapes",
);

pub const NODE: Section = section!("[node.\"path/name\"]", "Patches what a model brought, by the names on the way down joined with `/`, by the last name, or by the index of the node in the file. Two that match are an error.",
    "visible": "boolean" = "true"; "false leaves the node's own shapes and lights out; those of nodes below it stay",
    "group": "name" = "its materials'"; "light group of its lights and of its shapes that shine",
    "material": "string" = "its own"; "name of a `[[material]]`",
);

pub const SENSOR: Section = section!("[[sensor]]", "A meter, read by `steradian measure` (docs/measure.md). Pictures do not show it and it blocks no light.",
    "name": "string" = "required"; "shown in the results",
    "type": "\"radiance\", \"irradiance\" or \"flux\"" = "required"; "along a ray; at a point or over a shape, a square metre; over a whole shape",
    "position": "[x, y, z] m" = "required without `shape`"; "where it stands",
    "direction": "[x, y, z]" = "required for radiance"; "where it looks",
    "normal": "[x, y, z]" = "required for irradiance at a point"; "of the side that light arrives at",
    "shape": "string" = "required for flux"; "measures over all shapes of that name together, the mean by area for irradiance",
    "side": "\"front\" or \"back\"" = "\"front\""; "of the shape; the front of closed shapes is outside",
    "light": "\"arriving\" or \"leaving\"" = "\"arriving\""; "leaving: emitted and reflected, the exitance",
);

/// In the order of the page.
pub const SECTIONS: &[&Section] = &[
    &TOP,
    &CAMERA,
    &FILM,
    &SKY,
    &LIGHT,
    &POINT,
    &SPOT,
    &DIRECTIONAL,
    &TEXTURE,
    &MATERIAL,
    &VALUE,
    &SHAPE,
    &SPHERE,
    &DISC,
    &RECTANGLE,
    &BOX,
    &MESH,
    &MODEL,
    &COPY,
    &NODE,
    &SENSOR,
];

/// The tables of docs/scene.md.
pub fn markdown() -> String {
    use std::fmt::Write;
    let mut page = String::new();
    let cell = |s: &str| s.replace('|', "\\|");
    for section in SECTIONS {
        let _ = write!(
            page,
            "\n## {}\n\n{}\n\n| key | form | when left out | meaning |\n|---|---|---|---|\n",
            section.name, section.doc
        );
        for key in section.keys {
            let _ =
                writeln!(page, "| `{}` | {} | {} | {} |", key.name, cell(key.form), cell(key.default), cell(key.doc));
        }
    }
    page.push_str("\n## Material types and their inputs\n");
    for model in crate::bsdf::MODELS {
        let _ = write!(
            page,
            "\n### type = \"{}\"\n\n{}\n\n| input | kind | default | range | meaning |\n|---|---|---|---|---|\n",
            model.keyword, model.doc
        );
        for input in model.inputs {
            let d = input.default;
            let (kind, default) = match input.kind {
                crate::bsdf::InputKind::Scalar => ("number", format!("{}", d[0])),
                crate::bsdf::InputKind::Color => ("colour", format!("[{}, {}, {}]", d[0], d[1], d[2])),
            };
            let _ = writeln!(
                page,
                "| `{}` | {kind} | {default} | {}..{} | {} |",
                input.name,
                input.range.0,
                input.range.1,
                cell(input.doc)
            );
        }
    }
    page
}

#[cfg(test)]
mod tests {
    #[test]
    fn docs_scene_md_holds_the_parser_s_keys() {
        const MARK: &str = "<!-- generated below: src/scene/format/toml/keys.rs -->\n";
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/scene.md");
        let page = std::fs::read_to_string(&path).unwrap();
        let (head, tables) = page.split_once(MARK).expect("docs/scene.md has the mark");
        if std::env::var_os("STERADIAN_BLESS").is_some() {
            std::fs::write(&path, format!("{head}{MARK}{}", super::markdown())).unwrap();
            return;
        }
        assert!(
            tables == super::markdown(),
            "docs/scene.md is behind the parser: run STERADIAN_BLESS=1 cargo test docs_scene_md"
        );
    }
}
