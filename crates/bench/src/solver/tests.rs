use glam::DVec3;
use render::{Gpu, Host};

use relight::{SolverBatch, solve_batch};

use super::family::SolverCase;
use super::found::FoundRoots;
use super::judge::ErrorBounds;
use super::truth::ExactCubic;
use super::width::FloatWidth;
use super::{
    AnswerTally, FAMILIES, Family, METHODS, MeasuredMethod, Method, Precision, SIXTEEN, SolverBenchReport, run, sixteen,
};
use crate::Progress;

/// Returns the tally of a method's answers, each changed by `alter`.
fn tally<F: FloatWidth>(
    family: Family,
    inputs: u64,
    method: Method,
    alter: impl Fn(FoundRoots<F>) -> FoundRoots<F>,
) -> AnswerTally {
    let mut tally = AnswerTally::default();
    for index in 0..inputs {
        let bars = ErrorBounds::<F>::new(family, &family.case(index));
        let found = method.solver::<F>()(&bars.case().curve, bars.case().q);
        tally.count(family, index, &bars, &alter(found));
    }
    tally
}

/// The other methods are correct implementations: for inputs without degeneracies they find every root, half of them to
/// 20 eps.
#[test]
fn all_solve_the_ordinary() {
    fn solves<F: FloatWidth>(method: Method) {
        let tally = tally::<F>(Family::Ordinary, 2000, method, |found| found);
        assert_eq!((tally.missed, tally.spurious, tally.nan), (0, 0, 0), "{method:?}: {:?}", tally.first_wrong);
        assert!(tally.error_u.quantiles().p50 < 20.0 * F::PRECISION.eps(), "{method:?}");
    }
    for method in METHODS {
        solves::<f32>(method);
        solves::<f64>(method);
    }
}

/// The paper's own method fails for the default light, a straight one, and for one with a small bend.
#[test]
fn cardano_fails_near_straight() {
    let straight = tally::<f32>(Family::Straight, 500, Method::Cardano, |found| found);
    assert!(straight.nan > 100, "{}", straight.nan);
    let nearly = tally::<f32>(Family::NearlyStraight, 500, Method::Cardano, |found| found);
    assert!(nearly.nan > 100 && nearly.missed > 100, "{} {}", nearly.nan, nearly.missed);
}

#[test]
fn ours_is_never_wrong() {
    fn holds<F: FloatWidth>(family: Family) {
        let tally = tally::<F>(family, 1000, Method::Ours, |found| found);
        assert_eq!((tally.wrong(), tally.nan), (0, 0), "{:?}", tally.first_wrong);
    }
    for family in FAMILIES {
        holds::<f32>(family);
        holds::<f64>(family);
    }
}

/// Each kind of wrong answer, made by altering right ones, is counted as that kind.
#[test]
fn planted_faults_are_judged() {
    let judge = |alter: fn(FoundRoots<f32>) -> FoundRoots<f32>| {
        let tally = tally(Family::Ordinary, 300, Method::Ours, alter);
        [tally.missed, tally.spurious, tally.inaccurate, tally.nan].map(|count| count > 0)
    };
    assert_eq!(judge(|right| right), [false, false, false, false]);
    assert_eq!(judge(|_| FoundRoots::from_iter([])), [true, false, false, false]);
    assert_eq!(judge(|right| right.roots().iter().copied().chain([0.123]).collect()), [false, true, false, false]);
    // 1e-4 is some thousand eps: well over the bound, and still the same root.
    assert_eq!(judge(|right| right.roots().iter().map(|u| u + 1e-4).collect()), [false, false, true, false]);
    assert_eq!(judge(|right| right.roots().iter().copied().chain([f32::NAN]).collect()), [false, false, false, true]);
}

/// The nearest point of a parabola is known by construction, and every root's residual in 106 bits.
#[test]
fn truth_is_true() {
    let mut case: SolverCase<f64> = Family::Ordinary.case(0);
    let s = &mut case.curve;
    (s.b0, s.d0, s.a) = (DVec3::ZERO, DVec3::X, DVec3::Y);
    // At u = 1/2: P = (1, 1/4), d = (1, 1/2); one step to the outer side, across d.
    let q = DVec3::new(1.5, -0.75, 0.0);
    let truth = ExactCubic::of(&case.curve, q);
    let root = truth.roots.iter().flatten().next().expect("one root");
    assert!(root.error(0.5) < 1e-30, "{:?}", root.u);
    for family in FAMILIES {
        for index in 0..200 {
            let SolverCase { curve, q } = family.case(index);
            let truth = ExactCubic::of(&curve, q);
            let size = (q - curve.b0).length() + curve.d0.length() + curve.d1.length();
            for root in truth.roots.iter().flatten() {
                // f is a sum of products of two lengths, each rounded to 2^-104; f64 would leave 1e-16.
                let bar = 1e-29 * size * size;
                assert!(truth.value(root.u).abs() <= bar, "{family:?} {index}: {}", truth.value(root.u) / bar);
            }
        }
    }
}

/// Each of sixteen lanes has the bits of the scalar solver, and a different bit in one lane is detected.
#[test]
fn sixteen_are_as_one() {
    let scalar = Method::Ours.solver::<f32>();
    let bits = |found: &FoundRoots<f32>| found.roots().iter().map(|u| u.to_bits()).collect::<Vec<_>>();
    let mut differ = 0;
    for family in FAMILIES {
        for first in (0..800).step_by(SIXTEEN) {
            let cases = sixteen(family, first);
            let mut many =
                solve_batch(&SolverBatch::new(&cases)).map(|roots| roots.found().collect::<FoundRoots<f32>>());
            for (lane, (curve, q)) in cases.iter().enumerate() {
                let one = scalar(curve, *q);
                assert_eq!(bits(&many[lane]), bits(&one), "{family:?} {}", first + lane as u64);
            }
            many[3] = many[3].roots().iter().map(|u| u.next_up()).collect();
            differ += usize::from(bits(&many[3]) != bits(&scalar(&cases[3].0, cases[3].1)));
        }
    }
    assert!(differ > 250, "{differ}");
}

/// Statements of docs/accuracy.md: over all families only the product's solver is never wrong, and it is the most
/// accurate. Far from the origin some others are never wrong either, and more accurate in f32.
fn says_what_the_docs_say(report: &SolverBenchReport) {
    let failures = |a: &AnswerTally| a.missed + a.spurious + a.inaccurate + a.nan;
    for precision in [Precision::F32, Precision::F64] {
        let (ours, others): (Vec<_>, Vec<_>) = report
            .methods
            .iter()
            .filter(|measured| measured.precision == precision)
            .partition(|measured| measured.method == Method::Ours);
        assert_eq!(failures(&ours[0].accuracy), 0);
        for other in others {
            assert!(failures(&other.accuracy) > 0, "{:?} {precision:?}", other.method);
            assert!(other.error() > ours[0].error(), "{:?} {precision:?}", other.method);
        }
    }
    let in_f32 = |method: Method| {
        let is_wanted = |measured: &&MeasuredMethod| (measured.method, measured.precision) == (method, Precision::F32);
        let measured = report.methods.iter().find(is_wanted).expect("every method");
        &measured.families.iter().find(|f| f.family == Family::FarOffset).expect("every family").accuracy
    };
    let ours = in_f32(Method::Ours).error_eps_cond.quantile(0.999);
    for better in [Method::Blinn, Method::Yuksel] {
        let accuracy = in_f32(better);
        assert!(failures(accuracy) == 0 && accuracy.error_eps_cond.quantile(0.999) < ours, "{better:?}");
    }
}

/// A small run of everything: CPU and GPU are never wrong, and no method is both faster and more accurate than the
/// product's.
#[test]
fn whole_run() {
    let gpu = Gpu::open(Host::default()).expect("a GPU, be it software");
    let judged = std::sync::atomic::AtomicUsize::new(0);
    let (report, svg) = run(300, &METHODS, Some(&gpu), |Progress { done, of, .. }| {
        assert!(done <= of);
        judged.fetch_max(done, std::sync::atomic::Ordering::Relaxed);
    })
    .expect("an adapter that computes");
    assert_eq!(judged.into_inner(), 300 * FAMILIES.len());
    assert_eq!(report.methods.len(), 2 * METHODS.len());
    let adapter = report.adapter.as_ref().expect("it was asked for");
    for (who, verdict) in
        [("ours", report.ours), ("sixteen", report.sixteen_wide.verdict), ("adapter", adapter.verdict)]
    {
        assert!(verdict.solves >= 300 * 15, "{who}");
        assert_eq!((verdict.wrong, verdict.nan), (0, 0), "{who}: {:?}", verdict.first_wrong);
    }
    assert!(adapter.solves_per_second > 0.0 && report.sixteen_wide.solves_per_second > 0.0);
    says_what_the_docs_say(&report);
    assert!(svg.contains("Cardano") && svg.contains("Ours"), "{svg}");
}
