// Pixels by themselves.

fn any_in_subgroup(here: bool) -> bool {
    return here;
}
