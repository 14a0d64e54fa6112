// Replaces subgroups.wgsl: each pixel by itself.

fn any_in_subgroup(here: bool) -> bool {
    return here;
}
