//! Several AOVs of one view: the pictures to draw, and the names of lights in files.

use light::LightInstance;

use crate::Aov;

/// Longest light name in bytes: the channel name that OpenEXR 1 reads, less the longest suffix.
const MAX_NAME: usize = 31 - ".direction.X".len();
/// Name of an unnamed light in files.
const NAMELESS: &str = "light";

/// Picture of one AOV that was requested, possibly of one light.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WantedPicture {
    pub aov: Aov,
    /// Index of the light that the picture is of. Other pictures do not use it.
    pub light: usize,
    /// Name of the light in files, if there are pictures of several lights.
    pub name: Option<String>,
}

/// Lists the pictures of `aovs`. AOVs of a light are those of the light with index `light`, or of every light that is
/// on if `light` is `None`. Beside AOVs of the camera, a light has its name, because both have an alpha.
pub fn wanted_pictures(aovs: &[Aov], light: Option<usize>, lights: &[LightInstance]) -> Vec<WantedPicture> {
    let mut names: Vec<String> = Vec::new();
    for light in lights {
        names.push(free_name(light.light.light().name(), &names));
    }
    let names_one = aovs.iter().any(|aov| !aov.is_per_light());
    let shine = |index: &usize| !lights[*index].light.light_profile().is_dark();
    let each = |aov| {
        let of = |light: usize| WantedPicture { aov, light, name: Some(names[light].clone()) };
        (0..lights.len()).filter(shine).map(of).collect()
    };
    let pictures = |aov: &Aov| match light {
        None if aov.is_per_light() => each(*aov),
        Some(light) if names_one && aov.is_per_light() && light < lights.len() => {
            vec![WantedPicture { aov: *aov, light, name: Some(names[light].clone()) }]
        }
        of => vec![WantedPicture { aov: *aov, light: of.unwrap_or_default(), name: None }],
    };
    aovs.iter().flat_map(pictures).collect()
}

/// Derives a name for files that is not in `taken`: without dots, which separate layers, and not too long.
fn free_name(name: &str, taken: &[String]) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | ' ') { c } else { '_' };
    // Leaves room for a number.
    let name: String = name.trim().chars().take(MAX_NAME - 4).map(plain).collect();
    let name = if name.is_empty() { NAMELESS.to_owned() } else { name };
    let mut names = std::iter::once(name.clone()).chain((2..).map(|n| format!("{name}_{n}")));
    names.find(|name| !taken.contains(name)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_have_names_of_their_own() {
        let mut names: Vec<String> = Vec::new();
        for name in ["key", "key", "", "", "fill.left", "späte Sonne über dem Meer bei Nacht"] {
            names.push(free_name(name, &names));
        }
        assert_eq!(names[..5], ["key", "key_2", "light", "light_2", "fill_left"]);
        assert!(names[5].starts_with("sp_te") && names[5].len() <= MAX_NAME, "{}", names[5]);
    }
}
