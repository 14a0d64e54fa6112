//! Tests the number of threads that draw, in child processes, in which no other test has started any.

use std::process::Command;

use light::Light;
use render::{Backend, View};

use super::both::{SIZE, demo, instances, renderer_of};

/// Draws the demo with `backend` in this process. Returns the picture and the number of relight threads.
fn shown_by(backend: Backend, size: [u32; 2]) -> (Vec<u8>, usize) {
    let loaded = demo("vases");
    let light: &Light = loaded.contents.lights[0].light();
    let mut renderer = renderer_of(backend);
    renderer.set_scene(&scene::pose(loaded.scene.clone())).expect("the scene fits");
    let view = View::beauty(loaded.contents.cameras[0].clone(), size);
    let bytes = renderer.render_display(&view, &instances(light)).expect("it can be drawn");
    (bytes, threads_that_relight())
}

/// Number of relight threads of this process.
fn threads_that_relight() -> usize {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux tells");
    let names = tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("comm")).ok());
    names.filter(|name| name.starts_with("relight")).count()
}

/// Command that runs only one of the tests below.
fn child(name: &str) -> Command {
    let mut command = Command::new(std::env::current_exe().expect("it runs"));
    command.args(["--ignored", "--exact", &format!("native::threads::{name}"), "--nocapture"]);
    command
}

#[test]
#[ignore = "the child of any_number_of_threads_shows_the_same_bytes"]
fn child_that_shows_the_demo() {
    let (bytes, threads) = shown_by(Backend::Native, SIZE);
    println!("shown {} by {threads} threads", format!("{bytes:?}").replace(' ', ""));
}

#[test]
fn any_number_of_threads_shows_the_same_bytes() {
    let with = |threads: &str| {
        let mut command = child("child_that_shows_the_demo");
        let output = command.env("RAYON_NUM_THREADS", threads).output().expect("it starts");
        let text = String::from_utf8(output.stdout).expect("text");
        let line = text.lines().find(|line| line.contains("shown ")).expect("it says what it shows");
        assert!(line.ends_with(&format!("by {threads} threads")), "{}", &line[line.len() - 30..]);
        line.split(' ').skip_while(|word| *word != "shown").nth(1).expect("bytes").to_owned()
    };
    let one = with("1");
    let bytes = SIZE.map(|side| side as usize).iter().product::<usize>() * 4;
    assert!(one.matches(',').count() + 1 == bytes && one.contains(",77,"), "no picture");
    for threads in ["2", "3", "8"] {
        assert!(with(threads) == one, "{threads} threads show something else");
    }
}

#[test]
#[ignore = "the child of where_the_device_draws_no_thread_relights"]
fn child_that_lets_the_device_draw() {
    let (_, threads) = shown_by(Backend::Wgpu, [64, 36]);
    println!("{threads} threads relight");
}

#[test]
fn where_the_device_draws_no_thread_relights() {
    let output = child("child_that_lets_the_device_draw").output().expect("it starts");
    let text = String::from_utf8(output.stdout).expect("text");
    assert!(output.status.success() && text.contains("\n0 threads relight"), "{text}");
}
