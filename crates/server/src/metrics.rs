//! Metrics of the server, for `GET /metrics`.

use std::time::Duration;

use prometheus_client::encoding::{EncodeLabelSet, text};
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::{Histogram, exponential_buckets};
use prometheus_client::registry::Registry;
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
    errors: Family<ErrorLabel, Counter>,
    /// Time from a request's head to its answer's, by route.
    request_seconds: Family<RouteLabel, Histogram, fn() -> Histogram>,
    /// Requests that have arrived and are not answered yet.
    requests_under_way: Gauge,
    /// Pictures that wait for drawing time, by urgency.
    render_queue: Family<UrgencyLabel, Gauge>,
    /// Time from a change to the start of drawing the picture that shows it in a view.
    pub frame_wait_seconds: Histogram,
    pub frames_rendered: Counter,
    pub frames_encoded: Family<CodecLabel, Counter>,
    /// Frames given to sockets.
    pub frames_sent: Family<CodecLabel, Counter>,
    pub frame_bytes_sent: Counter,
    /// Requests for records, by outcome.
    pub edits: Family<OutcomeLabel, Counter>,
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
    render_bytes: Family<MemoryLabel, Gauge>,
    render_memory: MemoryBudget,
    /// Bytes of bodies, answers and messages in memory, read from their budget when the metrics are requested.
    bytes_in_flight: Gauge,
    in_flight: ByteBudget,
}

/// Label of the encoding.
#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
pub struct CodecLabel {
    codec: &'static str,
}

/// Label of a finished edit: `committed`, or the code of the rejection.
#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
pub struct OutcomeLabel {
    outcome: &'static str,
}

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

/// Label of the route.
#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct RouteLabel {
    route: String,
}

/// Label of the error code.
#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct ErrorLabel {
    code: &'static str,
}

/// Label of the urgency of a picture.
#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct UrgencyLabel {
    urgency: &'static str,
}

/// Label of the kind of memory.
#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct MemoryLabel {
    kind: &'static str,
}

impl From<Codec> for CodecLabel {
    fn from(codec: Codec) -> Self {
        let codec = match codec {
            Codec::Jpeg => "jpeg",
            Codec::Png => "png",
        };
        Self { codec }
    }
}

impl Metrics {
    /// Makes the metrics, all at zero.
    pub fn new(render_memory: MemoryBudget, in_flight: ByteBudget) -> Self {
        // From a millisecond to 8 seconds. Each bound is twice the one before.
        let seconds: fn() -> Histogram = || Histogram::new(exponential_buckets(0.001, 2.0, 14));
        let mut metrics = Self {
            registry: Registry::default(),
            requests: Family::default(),
            errors: Family::default(),
            request_seconds: Family::new_with_constructor(seconds),
            requests_under_way: Gauge::default(),
            render_queue: Family::default(),
            frame_wait_seconds: seconds(),
            frames_rendered: Counter::default(),
            frames_encoded: Family::default(),
            frames_sent: Family::default(),
            frame_bytes_sent: Counter::default(),
            edits: Family::default(),
            commit_seconds: seconds(),
            render_seconds: seconds(),
            render_turn_seconds: seconds(),
            encode_seconds: seconds(),
            clients: Gauge::default(),
            rooms: Gauge::default(),
            scenes_decoded: Counter::default(),
            still_turns: Counter::default(),
            least_still_turns: Gauge::default(),
            solves_under_way: Gauge::default(),
            render_bytes: Family::default(),
            render_memory,
            bytes_in_flight: Gauge::default(),
            in_flight,
        };
        metrics.register();
        metrics
    }

    /// Returns the budget that counts the renderer's memory.
    pub fn render_memory(&self) -> &MemoryBudget {
        &self.render_memory
    }

    fn register(&mut self) {
        #[cfg(target_os = "linux")]
        self.registry.sub_registry_with_prefix("process").register_collector(Box::new(ProcessMetrics));
        let registry = self.registry.sub_registry_with_prefix("bendylights");
        registry.register("requests", "Requests that were answered", self.requests.clone());
        registry.register("errors", "Answers that refuse, by their code", self.errors.clone());
        let latency = "From a request's head to its answer's, waits included";
        registry.register("request_seconds", latency, self.request_seconds.clone());
        let under_way = "Requests that are being answered, or wait for it";
        registry.register("requests_under_way", under_way, self.requests_under_way.clone());
        let queue = "Pictures that wait for a turn of the renderer, by how soon they are wanted";
        registry.register("render_queue", queue, self.render_queue.clone());
        let wait = "From a change to the beginning of a view's picture of it";
        registry.register("frame_wait_seconds", wait, self.frame_wait_seconds.clone());
        registry.register("frames_rendered", "Pictures drawn for views", self.frames_rendered.clone());
        registry.register("frames_encoded", "Pictures encoded for views", self.frames_encoded.clone());
        registry.register("frames_sent", "Frames given to sockets", self.frames_sent.clone());
        registry.register(
            "frame_bytes_sent",
            "Bytes of frames given to sockets",
            self.frame_bytes_sent.clone(),
        );
        registry.register("edits", "Requests for records, by outcome", self.edits.clone());
        registry.register("commit_seconds", "Transactions of the store", self.commit_seconds.clone());
        registry.register("render_seconds", "Renders for views", self.render_seconds.clone());
        let turns = "Turns of the renderer, each a part of a picture or all of it";
        registry.register("render_turn_seconds", turns, self.render_turn_seconds.clone());
        registry.register("encode_seconds", "Encodings for views", self.encode_seconds.clone());
        registry.register("clients", "Clients that have said hello", self.clients.clone());
        registry.register("rooms", "Sessions that are open", self.rooms.clone());
        registry.register("scenes_decoded", "Scenes' files decoded", self.scenes_decoded.clone());
        registry.register(
            "still_turns",
            "How often pictures for HTTP were worked on",
            self.still_turns.clone(),
        );
        let least =
            "How often the picture for HTTP was worked on that was so least often, of those under way";
        registry.register("least_still_turns", least, self.least_still_turns.clone());
        let solves = "Drags of features that are solved or wait for it";
        registry.register("solves_under_way", solves, self.solves_under_way.clone());
        registry.register("render_bytes", "Bytes that the renderer keeps", self.render_bytes.clone());
        let in_flight = "Bytes of requests, answers and messages in memory";
        registry.register("bytes_in_flight", in_flight, self.bytes_in_flight.clone());
        let budget: Gauge = Gauge::default();
        budget.set(gauge(self.render_memory.budget()));
        registry.register("render_bytes_budget", "Bytes that the renderer keeps at most", budget);
    }

    /// Counts a request for a record as committed, or as refused with a code.
    pub fn count_edit(&self, refused: Option<ErrorCode>) {
        let outcome = refused.map_or("committed", ErrorCode::name);
        self.edits.get_or_create(&OutcomeLabel { outcome }).inc();
    }

    /// Counts a request as in progress until the returned value is dropped.
    pub fn request_begins(&self) -> RequestUnderWay {
        self.requests_under_way.inc();
        RequestUnderWay(self.requests_under_way.clone())
    }

    /// Counts an answered request, with its code if it was refused.
    pub fn count_request(&self, label: &RequestLabel, refused: Option<ErrorCode>, took: Duration) {
        let route = RouteLabel { route: label.route.clone() };
        self.request_seconds.get_or_create(&route).observe(took.as_secs_f64());
        self.requests.get_or_create(label).inc();
        if let Some(code) = refused {
            self.errors.get_or_create(&ErrorLabel { code: code.name() }).inc();
        }
    }

    /// Sets the number of waiting pictures of an urgency.
    pub fn note_queue(&self, urgency: &'static str, waiting: usize) {
        self.render_queue.get_or_create(&UrgencyLabel { urgency }).set(gauge(waiting as u64));
    }

    /// Returns all metrics in Prometheus' text format.
    pub fn to_text(&self) -> String {
        for kind in MemoryKind::ALL {
            let label = MemoryLabel { kind: kind.name() };
            self.render_bytes.get_or_create(&label).set(gauge(self.render_memory.bytes(kind)));
        }
        self.bytes_in_flight.set(gauge(self.in_flight.bytes() as u64));
        let mut out = String::new();
        text::encode(&mut out, &self.registry).expect("writing to a string does not fail");
        out
    }
}

/// A request in progress.
pub struct RequestUnderWay(Gauge);

impl Drop for RequestUnderWay {
    fn drop(&mut self) {
        self.0.dec();
    }
}

fn gauge(count: u64) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}
