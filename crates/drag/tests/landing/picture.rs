//! Drags judged by the picture before and after, with rays of the reference alone.

use drag::{Drag, DragChoice, DragResult, DragStatus, Feature, Viewport, drag_least_change};
use glam::DVec2;
use light::parameters::{END_MODE, ROTATION, SCALE, TRANSLATION};
use light::{CheckedLight, EndMode, Light};
use reference::{Reference, ReferenceLight, ShadedPoint};
use scene::View;

use crate::support::{self, TestScene, Trial, shadowing_node, trials};

const GRID: [u32; 2] = [72, 40];

struct Judge {
    reference: Reference,
    view: View,
    points: Vec<ShadedPoint>,
}

#[derive(Clone, Copy)]
struct Lit {
    brightness: f64,
    is_visible: bool,
}

impl Judge {
    fn new(scene: &TestScene) -> Self {
        let reference = scene.reference();
        let view = View::beauty(scene.view.camera.clone(), scene.view.size);
        let size = DVec2::from(scene.view.size.map(f64::from));
        let cell = size / DVec2::new(f64::from(GRID[0]), f64::from(GRID[1]));
        let pixels = (0..GRID[0] * GRID[1])
            .map(|k| DVec2::new(f64::from(k % GRID[0]) + 0.5, f64::from(k / GRID[0]) + 0.5) * cell);
        let points = pixels.filter_map(|pixel| reference.surface(&view, pixel)).collect();
        Self { reference, view, points }
    }

    fn at(&self, light: &ReferenceLight, surface: &ShadedPoint) -> Option<Lit> {
        let sample = self.reference.sample(light, surface)?;
        let cosine = surface.normal.dot(sample.coords.direction).max(0.0);
        Some(Lit { brightness: sample.irradiance.max_element() * cosine, is_visible: sample.is_visible })
    }

    fn picture(&self, light: &CheckedLight) -> Vec<Option<Lit>> {
        let light = ReferenceLight::new(light);
        self.points.iter().map(|surface| self.at(&light, surface)).collect()
    }

    /// Share of the lit pixels that keep half of their brightness. Pixels in the shadow of the moved caster do not
    /// count.
    fn kept(
        &self,
        before: &[Option<Lit>],
        after: &[Option<Lit>],
        moved: &CheckedLight,
        caster: Option<usize>,
    ) -> Option<f64> {
        let bright = |lit: &Option<Lit>| lit.filter(|lit| lit.is_visible).map_or(0.0, |lit| lit.brightness);
        let brightest = before.iter().map(bright).fold(0.0, f64::max);
        let (mut kept, mut all) = (0, 0);
        for ((was, is), surface) in before.iter().zip(after).zip(&self.points) {
            if bright(was) <= 0.1 * brightest {
                continue;
            }
            if caster.is_some()
                && is.is_some_and(|is| !is.is_visible)
                && shadowing_node(&self.reference, moved, surface) == caster
            {
                continue;
            }
            all += 1;
            kept += usize::from(bright(is) >= 0.5 * bright(was));
        }
        (all >= 20).then(|| f64::from(kept as u32) / f64::from(all as u32))
    }

    /// Returns the light that arrives at a pixel. `None` outside the light.
    fn brightness_at(&self, light: &CheckedLight, pixel: DVec2) -> Option<Lit> {
        self.at(&ReferenceLight::new(light), &self.reference.surface(&self.view, pixel)?)
    }
}

fn caster_node(judge: &Judge, light: &CheckedLight, pixel: DVec2) -> Option<usize> {
    shadowing_node(&judge.reference, light, &judge.reference.surface(&judge.view, pixel)?)
}

/// Makes `count` drags of shadows over 10 to 60 pixels, as an artist does: from and to surfaces that face the light, with
/// the caster in front of both.
fn shadow_drags(scene: &TestScene, judge: &Judge, deforms: bool, count: usize) -> Vec<Trial> {
    let short = |mut trial: Trial| {
        let drag = &mut trial.drag;
        let distance = drag.from.distance(drag.to);
        drag.to = drag.from.lerp(drag.to, (10.0 + 50.0 * (distance / 7.0).fract()) / distance);
        drag.points = deforms.then(|| (1..trial.light.light().points().len()).collect());
        let faces = |pixel| {
            let at = judge.brightness_at(&trial.light, pixel)?;
            (at.brightness > 0.0).then_some(())
        };
        faces(drag.from).and(faces(drag.to))?;
        let (from, _) = scene.tube_point(&trial.light, drag.from)?;
        let (to, _) = scene.tube_point(&trial.light, drag.to)?;
        let caster = scene.caster_of(&trial.light, drag.from)?;
        let is_in_front = [from, to].iter().all(|at| (caster - at.position).normalize().dot(at.normal) > 0.1);
        is_in_front.then_some(trial)
    };
    trials(scene, Feature::Shadow, 12 * count).filter_map(short).take(count).collect()
}

/// Results of drags that landed.
#[derive(Default)]
struct Landed {
    count: usize,
    seen: usize,
    kept: Vec<f64>,
}

fn judge_drags(judge: &Judge, drags: &[Trial], all: &mut Landed, solve: impl Fn(&Trial) -> DragResult) {
    for trial in drags {
        let result = solve(trial);
        if result.outcome.status != DragStatus::Landed {
            continue;
        }
        let moved = CheckedLight::new(result.light).expect("valid");
        let [was, is] = [(&trial.light, trial.drag.from), (&moved, trial.drag.to)]
            .map(|(light, pixel)| judge.brightness_at(light, pixel));
        all.count += 1;
        let is_seen = |(was, is): (Lit, Lit)| !is.is_visible && is.brightness >= 0.5 * was.brightness;
        all.seen += usize::from(was.zip(is).is_some_and(is_seen));
        let [before, after] = [&trial.light, &moved].map(|light| judge.picture(light));
        all.kept.extend(judge.kept(&before, &after, &moved, caster_node(judge, &trial.light, trial.drag.from)));
    }
    all.kept.sort_by(f64::total_cmp);
}

impl Landed {
    fn of(mut kept: Vec<f64>) -> Self {
        kept.sort_by(f64::total_cmp);
        Self { kept, ..Self::default() }
    }

    fn median(&self) -> f64 {
        self.kept[self.kept.len() / 2]
    }

    fn worst_tenth(&self) -> f64 {
        self.kept[self.kept.len() / 10]
    }
}

/// True if 85 % of the shadows land, nine in ten of these can be seen, and the median drag keeps 85 % of what was lit.
fn keeps_the_picture(landed: &Landed, of: usize) -> bool {
    100 * landed.count >= 85 * of && 10 * landed.seen >= 9 * landed.count && landed.median() >= 0.85
}

/// The solver passes; one that moves the light least is the planted fault.
#[test]
fn dragged_shadows_keep_the_picture() {
    const COUNT: usize = 12;
    let (mut of, mut by_picture, mut by_points) = (0, Landed::default(), Landed::default());
    for scene in support::scenes() {
        let judge = Judge::new(&scene);
        let drags = [false, true].map(|deforms| shadow_drags(&scene, &judge, deforms, COUNT)).concat();
        of += drags.len();
        judge_drags(&judge, &drags, &mut by_picture, |trial| scene.run(trial));
        judge_drags(&judge, &drags, &mut by_points, |trial| drag_least_change(&scene.bvh, &trial.light, &trial.drag));
    }
    for (landed, name) in [(&by_picture, "picture"), (&by_points, "points")] {
        let Landed { count, seen, .. } = landed;
        let (median, tenth) = (landed.median(), landed.worst_tenth());
        println!("by {name}: {count} of {of} landed, {seen} seen, keep {median:.2}, {tenth:.2}");
    }
    assert!(keeps_the_picture(&by_picture, of));
    assert!(!keeps_the_picture(&by_points, of));
}

/// Lights of other shapes, a picture of one pixel and a drag that stays give a light that can be evaluated.
#[test]
fn every_light_and_view_gives_a_light() {
    let scene = support::demo();
    let trial = scene.trial_of_the_demo(None);
    let placed = |light: Light| {
        let from = trial.light.light();
        let light = light.with(TRANSLATION, from.get(TRANSLATION)).with(ROTATION, from.get(ROTATION));
        CheckedLight::new(light).expect("valid")
    };
    let lights = [trial.light.clone(), placed(Light::spot()), placed(Light::omni()), placed(Light::directional())];
    let pixel = Viewport { size: [1, 1], ..trial.drag.view.clone() };
    let middle = DVec2::splat(0.5);
    for light in &lights {
        for feature in [Feature::Shadow, Feature::Hotspot, Feature::Highlight, Feature::Diffuse] {
            let moved = Drag { feature, points: None, ..trial.drag.clone() };
            let stays = Drag { to: moved.from, ..moved.clone() };
            let tiny = Drag { view: pixel.clone(), from: middle, to: middle, ..moved.clone() };
            for drag in [moved, stays, tiny] {
                let result = crate::drag(&scene.bvh, light, &drag, &[]);
                assert!(CheckedLight::new(result.light).is_ok(), "{feature:?} {:?}", result.outcome);
            }
        }
    }
}

/// The best of the alternatives keeps the picture in each scene, also in two by which no setting was chosen: four in five
/// drags land, four in five of these are seen, the median drag keeps nine tenths of what was lit, and the worst tenth of all
/// keeps seven tenths. The planted faults are a solver that moves the light least, and one that refuses everything.
#[test]
fn the_best_keeps_the_picture_of_each_scene() {
    const COUNT: usize = 25;
    let keeps = |landed: &Landed, of: usize| {
        5 * landed.count >= 4 * of && 10 * landed.seen >= 8 * landed.count && landed.median() >= 0.9
    };
    let mut kept = [Vec::new(), Vec::new()];
    for scene in support::scenes().into_iter().chain(support::unseen_scenes()) {
        let judge = Judge::new(&scene);
        let drags = shadow_drags(&scene, &judge, false, COUNT);
        let best = |trial: &Trial| {
            let drag = Drag { choice: Some(DragChoice::Best), source_outside: true, ..trial.drag.clone() };
            scene.run(&Trial { drag, ..trial.clone() })
        };
        let least_change = |trial: &Trial| drag_least_change(&scene.bvh, &trial.light, &trial.drag);
        let solvers: [&dyn Fn(&Trial) -> DragResult; 2] = [&best, &least_change];
        for (number, (solve, kept)) in solvers.into_iter().zip(&mut kept).enumerate() {
            let mut landed = Landed::default();
            judge_drags(&judge, &drags, &mut landed, solve);
            let (count, seen, median, tenth) = (landed.count, landed.seen, landed.median(), landed.worst_tenth());
            println!("{}: {count} of {} landed, {seen} seen, keep {median:.2}, {tenth:.2}", scene.name, drags.len());
            assert_eq!(keeps(&landed, drags.len()), number == 0, "{}", scene.name);
            kept.extend(landed.kept);
        }
    }
    let [best, least_change] = kept.map(|kept| Landed::of(kept).worst_tenth());
    println!("worst tenth of all: {best:.2}, by the least change {least_change:.2}");
    assert!(best >= 0.7 && least_change < 0.3, "{best} {least_change}");
    // The other planted fault: a solver that refuses everything.
    assert!(!keeps(&Landed { kept: vec![1.0], ..Landed::default() }, COUNT));
}

/// The picture of the demo shows no end of the light, and shows none after a drag: no pixel is beyond the end and would be
/// illuminated if the light went on.
#[test]
fn an_end_stays_out_of_the_picture() {
    let scene = support::demo();
    let trial = scene.trial_of_the_demo(None);
    let view = View::beauty(scene.view.camera.clone(), [128, 72]);
    let reference = scene.reference();
    let pixels = (0..128 * 72).map(|k| DVec2::new(f64::from(k % 128) + 0.5, f64::from(k / 128) + 0.5));
    let surfaces: Vec<_> = pixels.filter_map(|pixel| reference.surface(&view, pixel)).collect();
    let beyond_end = |light: &Light| {
        let extended = CheckedLight::new(light.clone().with(END_MODE, EndMode::Extend)).expect("valid");
        let (tube, source) = (extended.tube().expect("bendy"), ReferenceLight::new(&extended));
        let is_beyond = |surface: &&ShadedPoint| {
            let sample = reference.sample(&source, surface);
            sample.is_some_and(|lit| lit.is_visible && lit.coords.t > tube.n as f64)
        };
        surfaces.iter().filter(is_beyond).count()
    };
    assert_eq!(beyond_end(trial.light.light()), 0);
    let ends: Vec<usize> = (0..12)
        .filter_map(|turn| {
            let turn = f64::from(turn) * std::f64::consts::TAU / 12.0;
            let from = DVec2::new(520.5, 197.5);
            let to = from + 60.0 * DVec2::new(libm::cos(turn), libm::sin(turn));
            let drag = Drag { points: Some(vec![1, 2, 3, 4]), from, to, ..trial.drag.clone() };
            let result = drag::drag(&scene.bvh, &trial.light, &drag, &[]);
            (result.outcome.status == DragStatus::Landed).then(|| beyond_end(&result.light))
        })
        .collect();
    assert!(ends.len() > 8 && ends.iter().all(|pixels| *pixels == 0), "{ends:?}");
    // Deliberate fault that the check must detect: a light that ends above the table.
    let short = trial.light.light().clone().with(SCALE, 0.7);
    assert!(beyond_end(&short) > 10, "{}", beyond_end(&short));
}
