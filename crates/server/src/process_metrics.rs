//! Metrics of this process, with the names of Prometheus' own clients.

use std::fmt;

use procfs::process::{LimitValue, Process};
use procfs::{ProcResult, boot_time_secs, page_size, ticks_per_second};
use prometheus_client::collector::Collector;
use prometheus_client::encoding::{DescriptorEncoder, EncodeMetric};
use prometheus_client::metrics::counter::ConstCounter;
use prometheus_client::metrics::gauge::ConstGauge;

/// Reads the metrics on request. Leaves out those that the system does not give.
#[derive(Debug)]
pub struct ProcessMetrics;

struct Reading {
    cpu_seconds: f64,
    gauges: Vec<(&'static str, &'static str, f64)>,
}

impl Reading {
    fn take() -> ProcResult<Self> {
        let process = Process::myself()?;
        let stat = process.stat()?;
        let seconds = |ticks: u64| ticks as f64 / ticks_per_second() as f64;
        let mut gauges = vec![
            ("resident_memory_bytes", "Resident memory", (stat.rss * page_size()) as f64),
            ("virtual_memory_bytes", "Virtual memory", stat.vsize as f64),
            ("threads", "Threads", stat.num_threads as f64),
            ("open_fds", "Open files and sockets", process.fd_count()? as f64),
            ("start_time_seconds", "Start, in seconds since 1970", boot_time_secs()? as f64 + seconds(stat.starttime)),
        ];
        if let LimitValue::Value(most) = process.limits()?.max_open_files.soft_limit {
            gauges.push(("max_fds", "Open files and sockets at most", most as f64));
        }
        Ok(Self { cpu_seconds: seconds(stat.utime + stat.stime), gauges })
    }
}

impl Collector for ProcessMetrics {
    fn encode(&self, mut encoder: DescriptorEncoder<'_>) -> fmt::Result {
        let Ok(Reading { cpu_seconds, gauges }) = Reading::take() else { return Ok(()) };
        let cpu = ConstCounter::new(cpu_seconds);
        cpu.encode(encoder.encode_descriptor("cpu_seconds", "Processor time", None, cpu.metric_type())?)?;
        for (name, help, value) in gauges {
            let gauge = ConstGauge::new(value);
            gauge.encode(encoder.encode_descriptor(name, help, None, gauge.metric_type())?)?;
        }
        Ok(())
    }
}
