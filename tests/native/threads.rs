//! Tests the number of threads that draw, in child processes, in which no other test has started any.

use std::process::Command;

use light::Light;
use render::{Backend, View};

use super::both::{SIZE, demo};
use crate::pictures::{alone, renderer_of};

/// Draws the demo in this process, and prints the picture's bytes and the number of relight threads.
fn show_demo(backend: Backend) {
    let loaded = demo("vases");
    let light: &Light = loaded.contents.lights[0].light();
    let mut renderer = renderer_of(backend);
    renderer.set_scene(&scene::pose(loaded.scene.clone(), 0.0)).expect("the scene fits");
    let view = View::beauty(loaded.contents.cameras[0].clone(), SIZE);
    let bytes = renderer.render_display(&view, &alone(light)).expect("it can be drawn");
    let tasks = std::fs::read_dir("/proc/self/task").expect("the threads of this process");
    let names = tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("comm")).ok());
    let threads = names.filter(|name| name.starts_with("relight")).count();
    println!("shown {} by {threads} threads", format!("{bytes:?}").replace(' ', ""));
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
    show_demo(Backend::Native);
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
#[ignore = "the child of no_thread_relights_where_the_device_draws"]
fn child_that_lets_the_device_draw() {
    show_demo(Backend::Wgpu);
}

#[test]
fn no_thread_relights_where_the_device_draws() {
    let output = child("child_that_lets_the_device_draw").output().expect("it starts");
    let text = String::from_utf8(output.stdout).expect("text");
    let ends = text.lines().any(|line| line.ends_with(" by 0 threads"));
    assert!(output.status.success() && ends, "{}", &text[text.len().saturating_sub(200)..]);
}
