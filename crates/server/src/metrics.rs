//! Metrics of the server, for `GET /metrics`.

use std::time::Duration;

use prometheus_client::encoding::{EncodeLabelSet, text};
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::{Histogram, exponential_buckets};
use prometheus_client::registry::{Metric, Registry};
use protocol::ErrorCode;
use render::{MemoryBudget, MemoryKind};
use stream::Codec;

use crate::in_flight::ByteBudget;
#[cfg(target_os = "linux")]
use crate::process_metrics::ProcessMetrics;

/// All metrics, with the registry of their names.
#[derive(Debug)]
pub struct Metrics {
    registry: Registry,
    /// Answered requests, by route, method and status.
    requests: Family<RequestLabel, Counter>,
    /// Error answers, by code.
    errors: Family<Label, Counter>,
    /// Time from a request's head to its answer's, by route.
    request_seconds: Family<Label<String>, Histogram, fn() -> Histogram>,
    /// Requests that have arrived and are not answered yet.
    requests_under_way: Gauge,
    /// Pictures that wait for drawing time, by urgency.
    render_queue: Family<Label, Gauge>,
    /// Time from a change to the start of drawing the picture that shows it in a view.
    pub frame_wait_seconds: Histogram,
    pub frames_rendered: Counter,
    frames_encoded: Family<Label, Counter>,
    /// Frames given to sockets.
    frames_sent: Family<Label, Counter>,
    pub frame_bytes_sent: Counter,
    /// Requests for records, by outcome.
    edits: Family<Label, Counter>,
    /// Duration of a transaction of the store.
    pub commit_seconds: Histogram,
    /// Time spent on drawing a picture for a view.
    pub render_seconds: Histogram,
    /// Duration of a slice of drawing time, in which the renderer draws a picture or a part of it.
    pub render_turn_seconds: Histogram,
    /// Time spent on encoding a picture for a view.
    pub encode_seconds: Histogram,
    /// Clients that have said hello.
    pub clients: Gauge,
    /// Open sessions.
    pub rooms: Gauge,
    /// Decoded scene files, each of which may take gigabytes.
    pub scenes_decoded: Counter,
    /// Slices of drawing time that pictures for HTTP have had.
    pub still_turns: Counter,
    /// Least number of slices that any unfinished picture for HTTP has had.
    pub least_still_turns: Gauge,
    /// Drags of features that are being solved or wait.
    pub solves_under_way: Gauge,
    /// Bytes of the renderer's memory by kind, read from its budget when the metrics are requested.
    render_bytes: Family<Label, Gauge>,
    render_memory: MemoryBudget,
    /// Bytes of bodies, answers and messages in memory, read from their budget when the metrics are requested.
    bytes_in_flight: Gauge,
    in_flight: ByteBudget,
}

/// A label of one metric, with its value.
type Label<T = &'static str> = [(&'static str, T); 1];

/// Labels of an answered request: its method, its route and the status of its answer.
#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
pub struct RequestLabel {
    /// `GET`, `HEAD`, `POST` or `other`.
    pub method: &'static str,
    /// Route of the router: `/sessions/{name}`.
    pub route: String,
    /// HTTP status.
    pub status: u16,
}

impl Metrics {
    /// Makes the metrics, all at zero.
    pub fn new(render_memory: MemoryBudget, in_flight: ByteBudget) -> Self {
        let mut registry = Registry::default();
        #[cfg(target_os = "linux")]
        registry.sub_registry_with_prefix("process").register_collector(Box::new(ProcessMetrics));
        let mut own = OwnMetrics(registry.sub_registry_with_prefix("bendylights"));
        // The order is that of `/metrics`.
        let metrics = Self {
            requests: own.add("requests", "Requests that were answered"),
            errors: own.add("errors", "Answers that refuse, by their code"),
            request_seconds: own.register(
                "request_seconds",
                "From a request's head to its answer's, waits included",
                Family::new_with_constructor(seconds),
            ),
            requests_under_way: own.add("requests_under_way", "Requests that are being answered, or wait for it"),
            render_queue: own
                .add("render_queue", "Pictures that wait for a turn of the renderer, by how soon they are wanted"),
            frame_wait_seconds: own
                .seconds("frame_wait_seconds", "From a change to the beginning of a view's picture of it"),
            frames_rendered: own.add("frames_rendered", "Pictures drawn for views"),
            frames_encoded: own.add("frames_encoded", "Pictures encoded for views"),
            frames_sent: own.add("frames_sent", "Frames given to sockets"),
            frame_bytes_sent: own.add("frame_bytes_sent", "Bytes of frames given to sockets"),
            edits: own.add("edits", "Requests for records, by outcome"),
            commit_seconds: own.seconds("commit_seconds", "Transactions of the store"),
            render_seconds: own.seconds("render_seconds", "Renders for views"),
            render_turn_seconds: own
                .seconds("render_turn_seconds", "Turns of the renderer, each a part of a picture or all of it"),
            encode_seconds: own.seconds("encode_seconds", "Encodings for views"),
            clients: own.add("clients", "Clients that have said hello"),
            rooms: own.add("rooms", "Sessions that are open"),
            scenes_decoded: own.add("scenes_decoded", "Scenes' files decoded"),
            still_turns: own.add("still_turns", "How often pictures for HTTP were worked on"),
            least_still_turns: own.add(
                "least_still_turns",
                "How often the picture for HTTP was worked on that was so least often, of those under way",
            ),
            solves_under_way: own.add("solves_under_way", "Drags of features that are solved or wait for it"),
            render_bytes: own.add("render_bytes", "Bytes that the renderer keeps"),
            bytes_in_flight: own.add("bytes_in_flight", "Bytes of requests, answers and messages in memory"),
            render_memory,
            in_flight,
            registry: Registry::default(),
        };
        let budget: Gauge = own.add("render_bytes_budget", "Bytes that the renderer keeps at most");
        budget.set(gauge(metrics.render_memory.budget()));
        Self { registry, ..metrics }
    }

    /// Returns the budget that counts the renderer's memory.
    pub fn render_memory(&self) -> &MemoryBudget {
        &self.render_memory
    }

    /// Counts a request for a record as committed, or as refused with a code.
    pub fn count_edit(&self, refused: Option<ErrorCode>) {
        let outcome = refused.map_or("committed", ErrorCode::name);
        self.edits.get_or_create(&[("outcome", outcome)]).inc();
    }

    /// Counts a picture encoded for a view.
    pub fn count_encoded_frame(&self, codec: Codec) {
        self.frames_encoded.get_or_create(&codec_label(codec)).inc();
    }

    /// Counts a frame given to a socket.
    pub fn count_sent_frame(&self, codec: Codec) {
        self.frames_sent.get_or_create(&codec_label(codec)).inc();
    }

    /// Counts a request as in progress until the returned value is dropped.
    pub fn request_begins(&self) -> RequestUnderWay {
        self.requests_under_way.inc();
        RequestUnderWay(self.requests_under_way.clone())
    }

    /// Counts an answered request, with its code if it was refused.
    pub fn count_request(&self, label: &RequestLabel, refused: Option<ErrorCode>, took: Duration) {
        self.request_seconds.get_or_create(&[("route", label.route.clone())]).observe(took.as_secs_f64());
        self.requests.get_or_create(label).inc();
        if let Some(code) = refused {
            self.errors.get_or_create(&[("code", code.name())]).inc();
        }
    }

    /// Sets the number of waiting pictures of an urgency.
    pub fn note_queue(&self, urgency: &'static str, waiting: usize) {
        self.render_queue.get_or_create(&[("urgency", urgency)]).set(gauge(waiting as u64));
    }

    /// Returns all metrics in Prometheus' text format.
    pub fn to_text(&self) -> String {
        for kind in MemoryKind::ALL {
            self.render_bytes.get_or_create(&[("kind", kind.name())]).set(gauge(self.render_memory.bytes(kind)));
        }
        self.bytes_in_flight.set(gauge(self.in_flight.bytes() as u64));
        let mut out = String::new();
        text::encode(&mut out, &self.registry).expect("writing to a string does not fail");
        out
    }
}

/// Registry of the server's own metrics.
struct OwnMetrics<'a>(&'a mut Registry);

impl OwnMetrics<'_> {
    /// Registers a metric and returns it.
    fn register<M: Metric + Clone>(&mut self, name: &str, help: &str, metric: M) -> M {
        self.0.register(name, help, metric.clone());
        metric
    }

    /// Registers a counter, a gauge or a family of them, at zero.
    fn add<M: Metric + Clone + Default>(&mut self, name: &str, help: &str) -> M {
        self.register(name, help, M::default())
    }

    /// Registers a histogram of seconds.
    fn seconds(&mut self, name: &str, help: &str) -> Histogram {
        self.register(name, help, seconds())
    }
}

/// A histogram from a millisecond to 8 seconds. Each bound is twice the one before.
fn seconds() -> Histogram {
    Histogram::new(exponential_buckets(0.001, 2.0, 14))
}

/// A request in progress.
pub struct RequestUnderWay(Gauge);

impl Drop for RequestUnderWay {
    fn drop(&mut self) {
        self.0.dec();
    }
}

fn codec_label(codec: Codec) -> Label {
    let name = match codec {
        Codec::Jpeg => "jpeg",
        Codec::Png => "png",
    };
    [("codec", name)]
}

fn gauge(count: u64) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}
