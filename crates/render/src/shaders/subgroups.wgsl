// Whether something holds for some pixel of those that are drawn together; no_subgroups.wgsl is for devices that cannot say.

fn any_in_subgroup(here: bool) -> bool {
    return subgroupAny(here);
}
