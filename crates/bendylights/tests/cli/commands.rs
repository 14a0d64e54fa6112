//! Tests of successful commands.

use exr::prelude::SampleType;
use image::Rgba32FImage;
use serde_json::{Value, json};

use crate::exr_channels;
use crate::program::{BENDY, Folder, SPOT, TRIANGLE, binary, json_for, printed, printed_for, run};

#[test]
fn eval_prints_one_object_a_point() {
    let folder = Folder::new();
    let light = folder.file("light.json", BENDY);
    let points = folder.file("points.json", "[[0,0,-1],[0,0,1],[0.1,0,-1]]");
    let text = printed(&["eval", &light, &points]);
    assert_eq!(printed_for(&["eval", &light], "[[0,0,-1],[0,0,1],[0.1,0,-1]]"), text, "from standard input");
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines.len(), 3, "a line a point");
    // P(u) = (0, 0, -2 u); R(1/2) = (0.1 + 2 0.4 + 0.8) / 4 = 0.425. On the axis light arrives from +Z.
    assert_eq!(
        lines[0],
        r#"[{"inside":true,"segment":0,"u":0.5,"t":0.5,"v":0.0,"w":0.0,"radius":0.42500000000000004,"direction":[0.0,0.0,1.0],"roots":[0.5]},"#
    );
    assert_eq!(lines[1], r#" {"inside":false,"roots":[]},"#);
    let answers: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(answers[2]["t"], json!(0.5));
    assert_eq!(printed_for(&["eval", &light], "[]"), "[]\n");
}

/// Two lights go from the left of the demo's blue vase to its right: one straight through it, one in an arc
/// over it.
#[test]
fn eval_says_what_is_in_the_way() {
    let folder = Folder::new();
    let light = |name: &str, middle: [f64; 3]| {
        let translation = [-2.0, 0.5, 0.25];
        let points = json!([[0, 0, 0], middle, [2.8, -0.2, 0.0]]);
        let transform = json!({ "translation": translation });
        let light = json!({ "type": "bendy", "points": points, "radii": [0.1, 0.1, 0.1], "transform": transform });
        folder.file(name, light.to_string())
    };
    let eval = |light: &str, scene: &[&str]| -> Value {
        let points = "[[0.68, 0.306, 0.25], [0.658, 0.519, 0.25], [9, 9, 9]]";
        json_for(&[&["eval", light], scene].concat(), points)
    };
    let in_scene = ["--scene", "demo:vases"];
    let straight = eval(&light("straight.json", [1.4, -0.1, 0.0]), &in_scene);
    assert_eq!((&straight[0]["visible"], &straight[0]["occluder"]), (&json!(false), &json!("blue vase")));
    let arc = light("arc.json", [1.38, 2.1, 0.0]);
    let over = eval(&arc, &in_scene);
    assert_eq!((&over[1]["visible"], over[1].get("occluder")), (&json!(true), Some(&Value::Null)));
    assert_eq!((&over[2]["inside"], over[2].get("visible")), (&json!(false), None), "outside");
    assert_eq!(eval(&arc, &[])[1].get("visible"), None, "only where it is asked for");
}

#[test]
fn bend_makes_the_cone_it_was_given() {
    let folder = Folder::new();
    let spot = folder.file("spot.json", SPOT);
    let bent = printed(&["bend", &spot, "--segments", "3"]);
    let light: Value = serde_json::from_str(&bent).expect("JSON");
    assert_eq!(
        (&light["type"], &light["name"], &light["decay"]),
        (&json!("bendy"), &json!("lamp"), &json!("inverseSquare"))
    );
    assert_eq!(light["points"].as_array().expect("points").len(), 5);

    // A cone of 20 degrees and length 6 in 3 segments has t = 3 z / 6 and R = z tan 20.
    let bent = folder.file("bent.json", bent);
    let answers = json_for(&["eval", &bent], "[[0,0,-3],[0.5,0,-3],[0,1.2,-3]]");
    let radius = 3.0 * 20.0_f64.to_radians().tan();
    for i in 0..2 {
        let close = |field: &str, value: f64| {
            let found = answers[i][field].as_f64().expect("a number");
            // The tolerance covers a dozen roundings of numbers about 1.
            assert!((found - value).abs() < 1e-14, "{field}: {found} for {value}");
        };
        close("t", 1.5);
        close("radius", radius);
        // v_hat = up x u_hat = Y x -Z = -X.
        close("v", if i == 0 { 0.0 } else { -0.5 / radius });
    }
    assert_eq!(answers[2], json!({"inside": false, "roots": []}), "1.2 is past the cone's 1.09");
}

/// `bend` keeps the part of a light without a cone that lies in the new cone, with its irradiance, and nothing
/// else.
#[test]
fn bend_keeps_of_a_light_without_a_cone_what_lies_in_one() {
    let folder = Folder::new();
    let scene = folder.file("scene.gltf", TRIANGLE);
    let drawn = |lights: &str| {
        let picture = folder.path("out.exr");
        let size = ["--size", "64x48", "--fill", "0", "-o", &picture];
        printed(&[&["render", &scene, "--lights", lights][..], &size].concat());
        exr_channels::beauty(&picture)
    };
    // Returns the largest relative difference of two pictures near their middle, where the triangle is.
    let apart = |a: &Rgba32FImage, b: &Rgba32FImage| {
        let near = |x: u32, y: u32| (f64::from(x) - 31.5).hypot(f64::from(y) - 23.5) < 10.0;
        let pixels = a.enumerate_pixels().filter(|(x, y, pixel)| near(*x, *y) && pixel[3] > 0.0);
        let shares = pixels.map(|(x, y, pixel)| (b.get_pixel(x, y)[1] / pixel[1] - 1.0).abs());
        shares.fold(0.0_f32, f32::max)
    };
    let bent = |light: &str, options: &[&str]| {
        let file = folder.file("light.json", light);
        let bent = printed(&[&["bend", &file][..], options].concat());
        let json: Value = serde_json::from_str(&bent).expect("JSON");
        assert_eq!(json["type"], "bendy");
        (drawn(&file), drawn(&folder.file("bent.json", bent)), json)
    };
    // 10 pixels from the middle are 0.7 units, or 35 degrees from the bulb, which stands a unit before the
    // triangle.
    let bulb = r#"{"type": "omni", "intensity": 5, "transform": {"translation": [0, 0, 1], "rotation": [0, 1, 0, 0]}}"#;
    let cone = ["--cone-angle", "48", "--toward", "0,0,-0.5"];
    for options in [&cone[..], &[&cone[..], &["--scene", &scene]].concat()] {
        let (before, after, _) = bent(bulb, options);
        // The GPU's picture is within 1e-3 of the exact one.
        assert!(apart(&before, &after) < 2e-3, "{}", apart(&before, &after));
        let corner = |picture: &Rgba32FImage| picture.get_pixel(19, 36)[1];
        assert!(corner(&before) > 0.0 && corner(&after) == 0.0, "outside of the cone");
    }
    // Deliberate fault that the check must detect: another target.
    let (before, after, _) = bent(bulb, &["--cone-angle", "48", "--toward", "-4,0,0"]);
    assert!(apart(&before, &after) > 0.5);
    // By default the light shines at the scene's centre, in a cone of 45 degrees.
    let (_, _, json) = bent(bulb, &["--scene", &scene]);
    assert_eq!((&json["coneAngle"], json["points"].as_array().map(Vec::len)), (&json!(45.0), Some(5)));
    assert!((json["points"][4][2].as_f64().expect("a number") + 1.0).abs() < 1e-12, "as far as the triangle");

    // A cone of 5 degrees holds the triangle from 16 units away. Its rays lean by 2.5 degrees at 0.7 units from
    // the axis. So cosines are 0.1 % smaller, and the reflection of a rough metal changes by as much.
    let sun = r#"{"type": "directional", "intensity": 2, "transform": {"translation": [9, 9, 9]}}"#;
    let (before, after, json) = bent(sun, &["--cone-angle", "5", "--scene", &scene]);
    assert!(apart(&before, &after) < 5e-3, "{}", apart(&before, &after));
    let from = &json["transform"]["translation"];
    assert!((from[2].as_f64().expect("a number") - 2.0_f64.sqrt() / 5.0_f64.to_radians().sin()).abs() < 1e-6);
    // A scene without lights gets the default key, which can be bent.
    let done = run(&["bend", "--scene", &scene]);
    assert!(done.code == 0 && done.stderr.contains("default key"), "{}", done.stderr);
    assert!(done.stdout.contains("\"default key\""), "{}", done.stdout);
}

#[test]
fn scenes_lists_the_demos() {
    assert!(printed(&["scenes"]).starts_with("demo:vases  "));
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let light = Folder::new();
    let light = (light.file("light.json", BENDY), light);
    let points = format!("[{}[0,0,-1]]", "[0,0,-1],".repeat(20_000));
    let points = light.1.file("points.json", points);
    let command = format!("{} eval {} {points} | head -n 1; echo ${{PIPESTATUS[0]}}", binary().display(), light.0);
    let output = std::process::Command::new("bash").args(["-c", &command]).output().expect("bash");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert!(output.stdout.ends_with(b"\n0\n"));
}

/// Renders the triangle, lit from the front. Returns the path of the picture.
fn rendered(folder: &Folder, name: &str, more: &[&str]) -> String {
    let scene = folder.file("scene.gltf", TRIANGLE);
    // The light stands before the triangle and shines along -Z onto all of it.
    let light = BENDY.replace("\"name\"", "\"transform\": {\"translation\": [0, 0, 1], \"scale\": 3}, \"name\"");
    let light = folder.file("light.json", light);
    let picture = folder.path(name);
    let args = [&["render", &scene, "--lights", &light, "--size", "64x48", "-o", &picture][..], more].concat();
    assert_eq!(printed(&args), "");
    assert_eq!(folder.names(), ["light.json", name, "scene.gltf"], "the picture and nothing else");
    picture
}

#[test]
fn render_writes_png_for_people() {
    let folder = Folder::new();
    let picture = |more: &[&str]| {
        let file = std::fs::read(rendered(&folder, "out.png", more)).expect("a file");
        // Programs read the color space from this chunk.
        assert!(file.windows(4).any(|bytes| bytes == b"sRGB"));
        image::load_from_memory(&file).expect("a PNG").into_rgba8()
    };
    let seen = picture(&["--samples", "16", "--background", "transparent"]);
    let picture_of = &picture;
    let picture = picture_of(&["--samples", "2"]);
    assert_eq!(picture.dimensions(), (64, 48));
    let (middle, corner) = (picture.get_pixel(32, 26), picture.get_pixel(1, 1));
    assert!(middle[1] > corner[1], "the triangle is lit and the background is not: {middle:?}, {corner:?}");
    // Behind the triangle there is nothing. A pixel at its edge has the color of the middle, and a partial
    // alpha.
    let alphas: Vec<u8> = seen.pixels().map(|pixel| pixel[3]).collect();
    assert_eq!((seen.get_pixel(1, 1).0, seen.get_pixel(32, 26)[3]), ([0; 4], 255));
    assert!(alphas.iter().any(|alpha| (1..255).contains(alpha)));
    let again = picture_of(&["--aov", "visibility", "--light", "key", "--camera", "front"]);
    assert_eq!(again.get_pixel(32, 26).0[..3], [255; 3], "written over: nothing stands before the triangle");
}

/// All backends show all of the camera's frame. Without `--size` the picture has the frame's shape.
#[test]
fn render_keeps_what_the_camera_frames() {
    let folder = Folder::new();
    // The camera frames 2.4 by 0.8 around the triangle, which is 2 wide and 2 high. Its sides are visible, its
    // top and bottom are not.
    let yfov = 2.0 * 0.1_f64.atan();
    let framed = format!(r#"{{"yfov": {yfov}, "aspectRatio": 3, "znear": 0.1}}"#);
    let scene = TRIANGLE.replace(r#"{"yfov": 0.8, "znear": 0.1}"#, &framed);
    let scene = folder.file("scene.gltf", scene);
    let covered = |args: &[&str]| {
        let picture = folder.path("out.exr");
        let done = run(&[&["render", &scene, "--aov", "depth", "-o", &picture], args].concat());
        assert_eq!(done.code, 0, "{}", done.stderr);
        let picture = exr_channels::picture(&exr_channels::open(&picture), ["Z", "Z", "Z", "A"]);
        let count = |row: u32| (0..picture.width()).filter(|&x| picture.get_pixel(x, row)[3] > 0.0).count();
        let columns = |x: u32| (0..picture.height()).filter(|&y| picture.get_pixel(x, y)[3] > 0.0).count();
        let [width, height] = [picture.width(), picture.height()];
        (picture.dimensions(), count(height / 2), columns(width / 2))
    };
    // At half its height the triangle is 1 wide: 1 / 2.4 of the width. A square picture shows all of it, 2 high
    // in 2.4, except for its tip, which lies half a pixel beside the middle column.
    for backend in ["native", "wgpu", "reference"] {
        let square = covered(&["--size", "240x240", "--backend", backend]);
        assert_eq!(square, ((240, 240), 100, 199), "{backend}");
        let wide = covered(&["--size", "480x80", "--backend", backend]);
        assert_eq!(wide, ((480, 80), 100, 80), "{backend}: its height is kept");
        // The default number of pixels, 640 x 360, in a picture three times as wide as high.
        assert_eq!(covered(&["--backend", backend]).0, (831, 277), "{backend}");
    }
    folder.file("scene.gltf", TRIANGLE);
    assert_eq!(covered(&[]).0, (640, 360), "a camera that does not say: 16:9, to the pixel");
}

/// In all backends `--fill 0` leaves the light's own radiance, and the rest is the fill.
#[test]
fn render_takes_the_fill_away() {
    let folder = Folder::new();
    let drawn = |backend: &str, fill: &str| {
        let picture = folder.path("out.exr");
        let render = ["render", "demo:vases", "--size", "96x54", "-o", &picture];
        printed(&[&render[..], &["--backend", backend, "--fill", fill]].concat());
        exr_channels::beauty(&picture)
    };
    let [native, wgpu, reference] =
        ["native", "wgpu", "reference"].map(|backend| ["0", "1"].map(|fill| drawn(backend, fill)));
    assert_fill_is_added(&native, &reference);
    assert_fill_is_added(&wgpu, &reference);
}

/// Asserts that pictures without and with the fill differ by it, as those of the reference do.
fn assert_fill_is_added(drawn: &[image::Rgba32FImage; 2], reference: &[image::Rgba32FImage; 2]) {
    let (mut dark, mut differ) = (0, 0);
    for (x, y, [_, _, _, covered]) in drawn[0].enumerate_pixels().map(|(x, y, pixel)| (x, y, pixel.0)) {
        let at = |pictures: &[image::Rgba32FImage; 2]| {
            [0, 1, 2].map(|c| {
                (pictures[0].get_pixel(x, y)[c], pictures[1].get_pixel(x, y)[c] - pictures[0].get_pixel(x, y)[c])
            })
        };
        let (ours, truth) = (at(drawn), at(reference));
        let is_dark = |pixel: [(f32, f32); 3]| pixel.iter().all(|(alone, _)| *alone == 0.0);
        dark += u32::from(covered == 1.0 && is_dark(ours) && is_dark(truth));
        // The fill is at most 0.145 times a color. A surface stores a color's square root in 13 bits, a step of
        // 2.5e-4, and a normal to 2^-15. The reference rounds once, but to the f32 of a sum with up to 4 of
        // light.
        let far = ours.iter().zip(&truth).any(|((_, ours), (_, truth))| (ours - truth).abs() > 0.145 * 4e-4);
        differ += u32::from(far);
        // Control: the fill is present.
        assert!(covered == 0.0 || ours.iter().any(|(_, fill)| *fill > 1e-3), "{x} {y}");
    }
    // A third of the demo lies outside its light. At silhouettes the two backends may see different surfaces.
    assert!(dark > 96 * 54 / 3, "{dark}");
    assert!(differ <= 96 * 54 / 1000, "{differ}");
}

/// On a terminal a bar shows the progress and the remaining time. The picture is the same.
#[test]
fn render_says_how_far_it_is() {
    let folder = Folder::new();
    for backend in ["native", "reference"] {
        let picture = |name: &str| folder.path(&format!("{backend}-{name}.exr"));
        let render = |out: &str| format!("render demo:vases --size 160x90 --samples 16 --backend {backend} -o {out}");
        let command = format!("{} {}", binary().display(), render(&picture("seen")));
        // `script` runs the command on a terminal and prints the terminal's output.
        let seen = std::process::Command::new("script").args(["-qec", &command, "/dev/null"]).output().expect("script");
        assert!(seen.status.success());
        let text = String::from_utf8_lossy(&seen.stdout);
        let percents: Vec<u32> =
            text.split(" %").filter_map(|before| before.rsplit(' ').next()?.parse().ok()).collect();
        assert!(!percents.is_empty() && percents.is_sorted(), "{backend}: {text:?}");
        assert!(text.contains("s left"), "{backend}: {text:?}");

        let alone = render(&picture("unseen"));
        assert_eq!(printed(&alone.split(' ').collect::<Vec<_>>()), "", "nothing is written elsewhere");
        let bytes = |name: &str| std::fs::read(picture(name)).expect("a picture");
        assert!(bytes("seen") == bytes("unseen"), "{backend}");
    }
}

#[test]
fn render_takes_shadow_settings() {
    let folder = Folder::new();
    let shadows = ["--aov", "visibility", "--shadow-resolution", "512", "--shadow-mesh-error", "0.01"];
    let picture = image::open(rendered(&folder, "out.png", &shadows)).expect("a PNG").into_rgba8();
    assert_eq!(picture.get_pixel(32, 26).0[..3], [255; 3], "nothing stands before the triangle");
}

#[test]
fn render_writes_exr_with_the_values_themselves() {
    let folder = Folder::new();
    let file = exr_channels::open(&rendered(&folder, "out.exr", &["--aov", "depth"]));
    let types = exr_channels::types(&file);
    assert_eq!(types, [("A".into(), SampleType::F32), ("Z".into(), SampleType::F32)].into());
    let picture = exr_channels::picture(&file, ["Z", "Z", "Z", "A"]);
    assert_eq!(picture.get_pixel(0, 0).0, [f32::INFINITY, f32::INFINITY, f32::INFINITY, 0.0], "nothing is there");
    let depth = picture.get_pixel(32, 26)[0];
    // The plane lies 4 units before the camera. Depth is stored as 1 / z over a near plane of 0.1, in a float
    // of 24 bits: half a step is 4^2 / 0.1 * 2^-25.
    assert!((depth - 4.0).abs() < 5e-6, "{depth}");
}

/// One drawing can give several files, and one file can hold all AOVs.
#[test]
fn render_puts_all_quantities_in_one_file() {
    let folder = Folder::new();
    let [all, png, exr] = ["all.exr", "one.png", "one.exr"].map(|name| folder.path(name));
    let size = ["render", "demo:vases", "--size", "96x54"];
    printed(&[&size[..], &["--aov", "all", "-o", &all]].concat());
    printed(&[&size[..], &["-o", &png, "-o", &exr]].concat());
    let file = exr_channels::open(&all);
    let types = exr_channels::types(&file);
    let floats = ["R", "G", "B", "A", "key.A", "Z", "P.X", "P.Y", "P.Z", "key.t", "key.v", "key.w"];
    let halves = ["N.X", "N.Y", "N.Z", "key.visibility"];
    let of = |names: &[&str], kind| names.iter().map(|name| ((*name).to_owned(), kind)).collect::<Vec<_>>();
    let directions = ["key.direction.X", "key.direction.Y", "key.direction.Z"];
    let expected =
        [of(&floats, SampleType::F32), of(&halves, SampleType::F16), of(&directions, SampleType::F16)].concat();
    assert_eq!(types, expected.into_iter().collect());
    assert!(exr_channels::picture(&file, ["R", "G", "B", "A"]) == exr_channels::beauty(&exr));
    // Position and depth agree: the matrix of the header transforms the position to its depth.
    let [position, depth] =
        [["P.X", "P.Y", "P.Z", "A"], ["Z", "Z", "Z", "A"]].map(|names| exr_channels::picture(&file, names));
    let matrix = file.layer_data.attributes.world_to_camera.expect("the header has it");
    let mut seen = 0;
    for (at, depth) in position.pixels().zip(depth.pixels()).filter(|(at, _)| at[3] > 0.0) {
        let z = (0..3).map(|row| at[row] * matrix[4 * row + 2]).sum::<f32>() + matrix[14];
        // The tolerance is that of a sum of four products of numbers below 8.
        assert!((z + depth[0]).abs() < 4.0 * 8.0 * f32::EPSILON * 4.0, "{at:?} {depth:?}");
        seen += 1;
    }
    assert!(seen > 96 * 54 / 2);
    // The PNG comes from the same drawing: its tone mapping grows with the radiance.
    let (png, beauty) = (image::open(&png).expect("a PNG").into_rgb8(), exr_channels::beauty(&exr));
    let bright = |y: u32, x: u32| (beauty.get_pixel(x, y)[1], png.get_pixel(x, y)[1]);
    let mut pixels: Vec<_> = (0..54).flat_map(|y| (0..96).map(move |x| (y, x))).map(|(y, x)| bright(y, x)).collect();
    pixels.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (dark, light) = (pixels[pixels.len() / 4].1, pixels[3 * pixels.len() / 4].1);
    assert!(dark < light, "{dark} {light}");
    let chromaticities = file.attributes.chromaticities.expect("the header has them");
    assert_eq!((chromaticities.red.x(), chromaticities.white.y()), (0.64, 0.329));
    for (args, words) in [
        (vec!["--aov", "depth,normal", "-o", "a.png"], "a PNG shows one quantity"),
        (vec!["--light", "key", "-o", "a.png"], "beauty is not of one light"),
    ] {
        let done = run(&[&size[..], &args].concat());
        assert!(done.code == 2 && done.stderr.contains(words), "{}", done.stderr);
    }
}

#[test]
fn render_draws_a_wireframe_of_the_shadow_map() {
    let folder = Folder::new();
    let drawn = exr_channels::open(&rendered(&folder, "out.exr", &["--aov", "wireframe"]));
    let drawn = exr_channels::picture(&drawn, ["t", "edge", "edge", "A"]);
    let on_triangle: Vec<_> = drawn.pixels().filter(|pixel| pixel[3] == 1.0).collect();
    assert!(on_triangle.len() > 100 && on_triangle.iter().all(|pixel| pixel[0] > 0.0 && pixel[0] < 1.0));
    let scene = folder.path("scene.gltf");
    let truth = folder.path("truth.exr");
    let lights = folder.path("light.json");
    let args = ["render", &scene, "--lights", &lights, "--aov", "wireframe", "--backend", "reference", "-o", &truth];
    let done = run(&args);
    assert_eq!(done.code, 2);
    assert!(done.stderr.contains("no shadow map"), "{}", done.stderr);
    assert_eq!(folder.names(), ["light.json", "out.exr", "scene.gltf"]);
}

/// The default key is only for calls without a light file. A light file may be empty, which gives a note.
#[test]
fn a_scene_without_lights_is_drawn_under_a_key_with_a_note() {
    let folder = Folder::new();
    let (scene, none) = (folder.file("scene.gltf", TRIANGLE), folder.file("none.json", "[]"));
    let (keyed, unlit) = (folder.path("keyed.png"), folder.path("unlit.png"));
    let note = |args: &[&str], says: &str| {
        let done = run(args);
        assert_eq!(done.code, 0, "{}", done.stderr);
        assert!(done.stderr.starts_with("note: ") && done.stderr.contains(says), "{}", done.stderr);
        assert_eq!(done.stderr.lines().count(), 1, "{}", done.stderr);
    };
    let key = "can be removed: default key";
    note(&["render", &scene, "--size", "32x32", "-o", &keyed], key);
    note(&["render", &scene, "--lights", &none, "--size", "32x32", "-o", &unlit], "there are no lights");
    let middle = |file: &str| image::open(file).expect("a picture").into_rgb8().get_pixel(16, 18)[1];
    assert!(middle(&keyed) > middle(&unlit) + 50, "{} {}", middle(&keyed), middle(&unlit));
    // The default key can be named and shown like any other light.
    let visibility = ["--aov", "visibility", "--light", "default key", "--size", "32x32"];
    note(&[&["render", &scene, "-o", &keyed], &visibility[..]].concat(), key);
    assert_eq!(middle(&keyed), 255);
    let done = run(&["render", &scene, "--lights", &none, "--aov", "t", "-o", &folder.path("t.png")]);
    assert_eq!(done.code, 2);
    assert!(done.stderr.contains("--lights"), "{}", done.stderr);
    assert_eq!(folder.names(), ["keyed.png", "none.json", "scene.gltf", "unlit.png"]);
}
