//! Several quantities of one view: which pictures that takes, and what files call each.

use light::LightInstance;

use crate::Aov;

/// Bytes of a channel's name that OpenEXR 1 reads, less what follows the light's name.
const MAX_NAME: usize = 31 - ".direction.X".len();
/// What files call a light that has no name.
const NAMELESS: &str = "light";

/// One picture that is wanted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WantedPicture {
    /// What it shows.
    pub aov: Aov,
    /// The index of the light that it is of, where it is of one.
    pub light: usize,
    /// What files call that light, where there are pictures of several.
    pub name: Option<String>,
}

/// The pictures of `aovs`. What is of a light is of that of index `light`; where that is `None` of each light that shines. Beside what
/// a camera sees of all lights a light has its name, since both have an alpha.
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

/// A name for files that none of `taken` is: without dots, which divide layers, and not too long.
fn free_name(name: &str, taken: &[String]) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | ' ') { c } else { '_' };
    // Room for a number.
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
