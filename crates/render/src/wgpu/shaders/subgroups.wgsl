// True if the condition holds for some pixel of the subgroup; no_subgroups.wgsl is for devices without subgroups.

fn any_in_subgroup(here: bool) -> bool {
    return subgroupAny(here);
}
