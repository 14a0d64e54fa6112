//! Statistics of pictures in wire form, for clients and traces.

use std::time::Duration;

use protocol::{Cause, Pass, PassRun};

/// Converts passes that ran from the renderer's type to the protocol's.
pub fn wire_pass_runs(runs: &[render::PassRun]) -> Vec<PassRun> {
    let run = |&render::PassRun { pass, light, cause, runs }: &render::PassRun| PassRun {
        pass: match pass {
            render::Pass::Gbuffer => Pass::Gbuffer,
            render::Pass::ShadowMap => Pass::ShadowMap,
            render::Pass::Lighting => Pass::Lighting,
            render::Pass::Layer => Pass::Layer,
            render::Pass::Sum => Pass::Sum,
            render::Pass::Display => Pass::Display,
        },
        light: light.map(|id| id.0),
        cause: match cause {
            render::Cause::First => Cause::First,
            render::Cause::Scene => Cause::Scene,
            render::Cause::Camera => Cause::Camera,
            render::Cause::Gbuffer => Cause::Gbuffer,
            render::Cause::Light => Cause::Light,
            render::Cause::Resolution => Cause::Resolution,
            render::Cause::Evicted => Cause::Evicted,
            render::Cause::NotKept => Cause::NotKept,
        },
        runs,
    };
    runs.iter().map(run).collect()
}

/// Converts a duration to whole microseconds, the unit in frames, statistics and traces.
pub fn micros(duration: Duration) -> u32 {
    duration.as_micros().try_into().unwrap_or(u32::MAX)
}
