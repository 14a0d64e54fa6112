//! A cursor that goes a little moves the light a little.

use drag::{Drag, Feature, Status, drag};
use glam::DVec3;

use crate::support::{self, Drawn, Trial, trials};

/// Places of a drag's path.
const STEPS: usize = 500;

/// What moves, as the contract counts it: control points in the world, where the light is moved as a whole too.
fn positions(light: &light::Light) -> Vec<DVec3> {
    let transform = light.transform();
    let rotation = transform.rotation.normalize();
    let in_world =
        |point: &light::ControlPoint| rotation * (point.position * transform.scale) + transform.translation;
    light.points().iter().map(in_world).collect()
}

/// What a path of the cursor makes of a light.
struct Path {
    /// The picked point of each place.
    picked: Vec<DVec3>,
    /// The direction there along which light is to arrive: the normal, or what a mirror sends to the eye.
    wanted: Vec<DVec3>,
    lights: Vec<Vec<DVec3>>,
    landed: usize,
    log: Vec<String>,
}

fn path(scene: &Drawn, trial: &Trial) -> Option<Path> {
    let mut path =
        Path { picked: Vec::new(), wanted: Vec::new(), lights: Vec::new(), landed: 0, log: Vec::new() };
    for step in 0..=STEPS {
        let to = trial.drag.from.lerp(trial.drag.to, step as f64 / STEPS as f64);
        let landing = drag(&scene.bvh, &trial.view, &trial.light, &Drag { to, ..trial.drag.clone() });
        if matches!(landing.status, Status::Refused(_)) {
            return None;
        }
        path.log.push(format!("{:?} {} {:.2}", landing.status, landing.iterations, landing.residual_px));
        path.landed += usize::from(landing.status == Status::Landed);
        path.picked.push(landing.to_world?);
        let seen = scene.seen(to)?;
        path.wanted.push(if trial.drag.feature == Feature::Highlight {
            seen.mirrored()
        } else {
            seen.normal
        });
        path.lights.push(positions(&landing.light));
    }
    Some(path)
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn a_small_step_of_the_cursor_moves_the_light_little() {
    let (mut smooth, mut jumping, mut jitters) = (0, 0, 0);
    for scene in support::scenes() {
        for feature in [Feature::Shadow, Feature::Hotspot, Feature::Highlight, Feature::Diffuse] {
            for (index, trial) in
                trials(&scene, feature, 6).filter(|trial| !trial.is_there_already()).enumerate()
            {
                let Some(path) = path(&scene, &trial) else { continue };
                let picks: Vec<f64> = path.picked.windows(2).map(|pair| pair[0].distance(pair[1])).collect();
                let pick = median(&picks);
                let points = path.lights[0].len();
                let step = |k: usize, point: usize| path.lights[k][point].distance(path.lights[k + 1][point]);
                let whole: Vec<f64> =
                    (0..STEPS).map(|k| (0..points).map(|point| step(k, point)).fold(0.0, f64::max)).collect();
                let typical = median(&whole).max(1e-12);
                let turns: Vec<f64> = path.wanted.windows(2).map(|pair| pair[0].distance(pair[1])).collect();
                let turn = median(&turns).max(1e-4);
                let turns_matter = matches!(feature, Feature::Highlight | Feature::Diffuse);
                let counts = |k: &usize| picks[*k] < 3.0 * pick && (!turns_matter || turns[*k] < 3.0 * turn);
                let worst = (0..STEPS).filter(counts).max_by(|&a, &b| whole[a].total_cmp(&whole[b]));
                let Some(worst) = worst else { continue };
                let is_whole = (0..STEPS).all(|k| counts(&k));
                let sums: Vec<f64> =
                    (0..points).map(|point| (0..STEPS).map(|k| step(k, point)).sum()).collect();
                let way = (0..points)
                    .map(|p| path.lights[0][p].distance(path.lights[STEPS][p]))
                    .fold(0.0, f64::max);
                let sum = sums.iter().copied().fold(0.0, f64::max);
                let jumps = whole[worst] > 20.0 * typical;
                if jumps {
                    jumping += 1;
                    for k in worst.saturating_sub(2)..(worst + 4).min(STEPS) {
                        println!(
                            "   {k} {} {:.2e} pick {:.2} turn {:.2e}",
                            path.log[k],
                            whole[k],
                            picks[k] / pick,
                            turns[k]
                        );
                    }
                    let jumps: Vec<usize> =
                        (0..STEPS).filter(|k| counts(k) && whole[*k] > 20.0 * typical).collect();
                    println!("   index {index} jumps: {} {:?}", jumps.len(), &jumps[..jumps.len().min(30)]);
                    println!(
                        "{} {feature:?} {:?} step {worst}: {:.1} medians ({typical:.2e}), {} landed, sum {sum:.3} of {way:.3}",
                        scene.name,
                        trial.drag.points,
                        whole[worst] / typical,
                        path.landed
                    );
                } else {
                    smooth += 1;
                    if is_whole && sum > 8.0 * way {
                        jitters += 1;
                        println!(
                            "{} {feature:?} {:?} {} landed, sum {sum:.3} of {way:.3}",
                            scene.name, trial.drag.points, path.landed
                        );
                    }
                }
            }
        }
    }
    println!("{smooth} smooth, {jumping} jump, {jitters} jitter");
    assert!(jumping == 0);
}

#[test]
fn dbg() {
    let Ok(which) = std::env::var("WHICH") else { return };
    let parts: Vec<&str> = which.split(',').collect();
    let scene = support::scenes().into_iter().find(|s| s.name == parts[0]).unwrap();
    let feature = match parts[1] {
        "S" => Feature::Shadow,
        "H" => Feature::Hotspot,
        "L" => Feature::Highlight,
        _ => Feature::Diffuse,
    };
    for (i, trial) in trials(&scene, feature, 6).filter(|trial| !trial.is_there_already()).enumerate() {
        if i != parts[2].parse::<usize>().unwrap() {
            continue;
        }
        println!("{:?}", trial.drag);
        for step in parts[3..].iter().map(|s| s.parse::<usize>().unwrap()) {
            let to = trial.drag.from.lerp(trial.drag.to, step as f64 / STEPS as f64);
            println!("step {step}");
            let landing = drag(&scene.bvh, &trial.view, &trial.light, &Drag { to, ..trial.drag.clone() });
            println!(
                "{:?} {:?} {:?}",
                landing.status,
                landing.light.points().iter().map(|p| p.position).collect::<Vec<_>>(),
                landing.light.transform()
            );
        }
    }
}
