//! Separating-axis test of boxes and segments.

use glam::{DVec3, Vec3};
use hierarchy::HierarchyNode;
use proptest::prelude::*;
use proptest::strategy::ValueTree;

use super::{misses_box, rounding_error};

/// Box and segment.
#[derive(Clone, Copy, Debug)]
struct Case {
    min: Vec3,
    max: Vec3,
    start: Vec3,
    span: Vec3,
}

fn cases() -> impl Strategy<Value = Case> {
    let point = |reach: f32| [-reach..reach, -reach..reach, -reach..reach].prop_map(Vec3::from);
    // Flat boxes too, and segments along axes, whose products are 0.
    let size = (point(1.0), any::<bool>());
    let size = size.prop_map(|(size, is_flat)| if is_flat { size.abs().with_y(0.0) } else { size.abs() });
    let span = (point(8.0), 0u32..8).prop_map(|(span, zeros)| {
        Vec3::from([0, 1, 2].map(|axis| if zeros >> axis & 1 == 1 && zeros != 7 { 0.0 } else { span[axis] }))
    });
    (point(3.0), size, point(6.0), span).prop_map(|(min, size, start, span)| Case { min, max: min + size, start, span })
}

impl Case {
    fn slack(&self) -> f32 {
        rounding_error(self.start) + rounding_error(self.start + self.span)
    }

    fn is_missed(&self) -> bool {
        let node = HierarchyNode { min: self.min.into(), max: self.max.into(), count: 0, next: 0 };
        misses_box(&node, self.start + 0.5 * self.span, 0.5 * self.span, self.slack())
    }

    /// True if a part of the segment is in the box enlarged by `room`, by the slab method (Liang and Barsky 1984) in
    /// f64.
    fn passes_through(&self, room: f64) -> bool {
        let (start, span) = (self.start.as_dvec3(), self.span.as_dvec3());
        let (min, max) = (self.min.as_dvec3() - room, self.max.as_dvec3() + room);
        let (mut first, mut last) = (0.0f64, 1.0f64);
        for axis in 0..3 {
            if span[axis] == 0.0 {
                if start[axis] < min[axis] || start[axis] > max[axis] {
                    return false;
                }
                continue;
            }
            let ends = [min[axis], max[axis]].map(|plane| (plane - start[axis]) / span[axis]);
            first = first.max(ends[0].min(ends[1]));
            last = last.min(ends[0].max(ends[1]));
        }
        first <= last
    }

    /// True if the boxes of both touch.
    fn touches_its_box(&self) -> bool {
        let end = self.start + self.span;
        let (low, high): (DVec3, DVec3) = (self.start.min(end).as_dvec3(), self.start.max(end).as_dvec3());
        self.min.as_dvec3().cmple(high).all() && self.max.as_dvec3().cmpge(low).all()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn no_box_that_a_segment_crosses_is_missed(case in cases()) {
        prop_assert!(!(case.is_missed() && case.passes_through(0.0)));
    }

    /// The rounding errors of the products are within twice the slack, and an edge is met at no less than the slack
    /// times the root of 2.
    #[test]
    fn boxes_beside_a_segment_are_missed(case in cases()) {
        prop_assert!(case.is_missed() || case.passes_through(f64::from(4.0 * case.slack())));
    }
}

#[test]
fn most_boxes_that_touch_the_box_of_a_segment_are_missed() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let cases: Vec<_> = (0..4000).map(|_| cases().new_tree(&mut runner).expect("a case").current()).collect();
    let touching: Vec<_> = cases.into_iter().filter(Case::touches_its_box).collect();
    let missed = touching.iter().filter(|case| case.is_missed()).count();
    assert!(missed > touching.len() / 2, "{missed} of {}", touching.len());
}
