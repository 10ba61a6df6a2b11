//! Light groups: names that tell lights apart in what a picture stores of each (the AOV `light_groups`).
//!
//! A lamp, the sky, and a material that shines may name one; what names none is of `DEFAULT_GROUP`. Numbers are places in the
//! sorted list of the names that some light of the scene has, so that records and files agree without a table.

use std::collections::BTreeSet;

use super::Scene;

/// Group of the lights that name none.
pub const DEFAULT_GROUP: &str = "default";

impl Scene {
    /// Names of the light groups, ascending: of lamps, of the sky, and of materials that shine and that some shape has.
    pub fn light_groups(&self) -> Vec<String> {
        let used = self.used_materials();
        let lamps = self.lights.iter().map(|l| &l.group);
        let sky = self.sky.iter().map(|_| &self.sky_group);
        let shines = |&(material, is_used): &(&super::Material, bool)| is_used && material.emits();
        let surfaces = self.materials.iter().zip(used).filter(shines).map(|(material, _)| &material.group);
        let names: BTreeSet<&str> = lamps.chain(sky).chain(surfaces).map(|g| name(g.as_deref())).collect();
        names.into_iter().map(str::to_owned).collect()
    }

    /// Which materials some shape has.
    pub fn used_materials(&self) -> Vec<bool> {
        let mut used = vec![false; self.materials.len()];
        for instance in &self.instances {
            if let Some(flag) = used.get_mut(instance.material) {
                *flag = true;
            }
        }
        used
    }
}

/// The name that a light's group has.
pub fn name(group: Option<&str>) -> &str {
    group.unwrap_or(DEFAULT_GROUP)
}

/// Number of a light's group among `groups`, which are all of the scene; 0 for what is not among them, which lights nothing.
pub fn number(groups: &[String], group: Option<&str>) -> u32 {
    groups.iter().position(|g| g == name(group)).unwrap_or(0) as u32
}

#[cfg(test)]
mod tests {
    use crate::reference::known::lamp;
    use crate::reference::scenes;
    use glam::DVec3;

    #[test]
    fn groups_are_those_of_lights_that_are_there() {
        let mut scene = scenes::lights::lamps(4);
        assert_eq!(scene.light_groups(), ["default", "key", "practical", "sky"]);
        // A material that no shape has lights nothing.
        scene.materials.push(crate::scene::Material { group: Some("unused".into()), ..lamp(DVec3::ONE) });
        assert_eq!(scene.light_groups().len(), 4);
        scene.sky = None;
        assert_eq!(scene.light_groups(), ["default", "key", "practical"]);
        assert!(crate::scene::Scene::default().light_groups().is_empty());
    }
}
