//! The node tree: which nodes are seen, and where each stands in the world (f64).

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};

use super::buffers::File;
use super::document::Node;
use crate::scene::Error;

/// A node of the chosen scene.
pub struct Placed {
    pub node: usize,
    /// Names from the root down, joined by '/'.
    pub path: String,
    pub to_world: DAffine3,
}

/// Deeper trees are refused: no model needs them, and a file could hold millions of levels.
const MAX_DEPTH: usize = 1024;

/// Nodes below scene `chosen`, else the file's default scene, else its first, else below every root; parents before children.
pub fn placed(file: &File<'_>, chosen: Option<usize>, notes: &mut Vec<String>) -> Result<Vec<Placed>, Error> {
    let nodes = &file.document.nodes;
    let scenes = &file.document.scenes;
    let asked_by = if chosen.is_some() { "the choice of a scene" } else { "the default scene" };
    let roots: Vec<usize> = match (chosen.or(file.document.scene), scenes.first()) {
        (Some(index), _) => file.at(scenes, index, "scene", asked_by)?.nodes.clone(),
        (None, Some(first)) => first.nodes.clone(),
        (None, None) => {
            let mut is_child = vec![false; nodes.len()];
            nodes.iter().flat_map(|n| &n.children).for_each(|c| {
                if let Some(flag) = is_child.get_mut(*c) {
                    *flag = true;
                }
            });
            if !nodes.is_empty() && is_child.iter().all(|c| *c) {
                return Err(file.error("node tree", "has no root: its nodes form a cycle; export it again"));
            }
            (0..nodes.len()).filter(|n| !is_child[*n]).collect()
        }
    };
    if scenes.len() > 1 {
        let taken = chosen.or(file.document.scene).unwrap_or(0);
        notes.push(format!("scene {taken} of {} taken, counted from 0; --scene chooses another", scenes.len()));
    }
    // The way down to each node, so that a cycle can be told from a node with two parents.
    let mut parent: Vec<Option<Option<usize>>> = vec![None; nodes.len()];
    let mut result: Vec<Placed> = Vec::new();
    let mut open: Vec<(usize, Option<usize>, usize)> = roots.iter().rev().map(|r| (*r, None, 0)).collect();
    while let Some((index, above, depth)) = open.pop() {
        let asked_by = above.map_or("the scene".into(), |p: usize| place(file, result[p].node));
        let node = file.at(nodes, index, "node", &asked_by)?;
        let up = above.map(|p| result[p].node);
        if parent[index].is_some() {
            let mut walk = up;
            while let Some(n) = walk.filter(|n| *n != index) {
                walk = parent[n].flatten();
            }
            let reason = match walk {
                Some(_) => "is its own ancestor: a cycle in the node tree; remove the link that closes it",
                None => "has two parents; give each its own copy of the node",
            };
            return Err(file.error(place(file, index), reason));
        }
        parent[index] = Some(up);
        if depth > MAX_DEPTH {
            return Err(
                file.error(place(file, index), format!("is more than {MAX_DEPTH} levels deep; flatten the tree"))
            );
        }
        if node.extensions.visibility.as_ref().is_some_and(|v| !v.visible) {
            notes.push(format!("{}: not visible, left out with what is below", place(file, index)));
            continue;
        }
        let local = local(node).map_err(|reason| file.error(place(file, index), reason))?;
        let name = node.name.clone().unwrap_or_else(|| format!("node {index}"));
        let (path, to_world) = match above {
            Some(p) => (format!("{}/{name}", result[p].path), result[p].to_world * local),
            None => (name, local),
        };
        if !to_world.is_finite() {
            return Err(file.error(place(file, index), "its transform is not finite; correct it"));
        }
        result.push(Placed { node: index, path, to_world });
        let here = result.len() - 1;
        open.extend(node.children.iter().rev().map(|c| (*c, Some(here), depth + 1)));
    }
    Ok(result)
}

/// `node 3 "name"`.
pub fn place(file: &File<'_>, index: usize) -> String {
    match file.document.nodes.get(index).and_then(|n| n.name.as_ref()) {
        Some(name) => format!("node {index} \"{name}\""),
        None => format!("node {index}"),
    }
}

/// Translation, rotation and scale, or the matrix.
fn local(node: &Node) -> Result<DAffine3, &'static str> {
    let Some(matrix) = &node.matrix else { return trs(node.translation, node.rotation, node.scale) };
    let m = DMat4::from_cols_array(matrix);
    if !m.is_finite() {
        return Err("its matrix is not finite; correct it");
    }
    if m.row(3) != glam::DVec4::W {
        return Err(
            "its matrix does not end in 0, 0, 0, 1: perspective cannot be placed; use translation, rotation and scale",
        );
    }
    Ok(DAffine3 { matrix3: DMat3::from_mat4(m), translation: m.w_axis.truncate() })
}

/// A rotation of length 0 is no rotation, and an error.
pub fn trs(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> Result<DAffine3, &'static str> {
    let rotation = DQuat::from_array(rotation);
    let length = rotation.length();
    if !(length.is_finite() && length > 1e-12) {
        return Err("its rotation is zero or not finite; use [0, 0, 0, 1] for none");
    }
    Ok(DAffine3::from_scale_rotation_translation(DVec3::from(scale), rotation / length, DVec3::from(translation)))
}
