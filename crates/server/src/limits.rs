//! How much of everything the server takes. What goes past one is refused, with its number in the sentence.

use std::time::Duration;

use crate::allowances::AllowanceRate;

/// Connections at once, sockets included; more wait until one ends.
pub const MAX_CONNECTIONS: usize = 640;
/// Bytes that the system holds for a connection until they are read, and until they are taken; it counts twice as many. It grows
/// them to tens of megabytes by itself, and a few hundred connections that neither take nor are read leave others none. At a tenth
/// of a second there and back a connection has 2.5 and 5 MB a second.
pub const RECEIVE_BUFFER_BYTES: usize = 256 << 10;
pub const SEND_BUFFER_BYTES: usize = 512 << 10;
/// Connections that have not shown the token, by a request or a hello. Where there are more the oldest is closed.
pub const MAX_ANONYMOUS_CONNECTIONS: usize = 128;
/// Requests of such connections that are answered at once, of signs of life and of all else; others wait for their turn.
pub const MAX_ANONYMOUS_REQUESTS: usize = 16;
/// Bytes a second of answers to them for each of those turns: 16 MiB a second together load the page a hundred times.
pub const ANONYMOUS_BYTES_PER_SECOND: u64 = 1 << 20;
/// Sockets that have said hello.
pub const MAX_SOCKETS: usize = 256;
/// HTTP requests that are carried out at once, once all of them has come.
pub const MAX_REQUESTS: usize = 64;
/// Pictures for HTTP that are rendered or wait for it.
pub const MAX_STILLS: usize = 8;
/// Bytes of the pictures that a request has drawn, before they are compressed: a beauty of 4096 x 4096 has all of it.
pub const MAX_PICTURE_BYTES: usize = 256 << 20;
/// Probes of pixels, and picks, whose rays are followed at once, a millisecond or so each; others wait.
pub const MAX_PROBES: usize = 4;
/// Drags of features that are solved or wait for it, each with a thread: one for each socket and each HTTP request.
pub const MAX_SOLVES: usize = MAX_SOCKETS + MAX_REQUESTS;
/// Counted steps up to which a solve is short, and goes before those that are long: some 20 ms, which most take.
pub const SHORT_SOLVE_STEPS: u64 = 20_000_000;
/// What the short solves of a client have before they count as long, in seconds of a core: some 25 drags a second of a usual light.
/// Where the processor has time for those too, they take no longer for it.
pub const SHORT_SOLVE_RATE: AllowanceRate = AllowanceRate { per_second: 0.1, burst: 0.2 };
/// Messages of a socket while a hand of another client moves a view: several times what a hand itself sends, who acknowledges
/// frames and drags or turns the camera.
pub const THROTTLED_MESSAGE_RATE: AllowanceRate = AllowanceRate { per_second: 400.0, burst: 400.0 };
/// Edits of a session, and of an actor, while a hand of another client moves a view, with `MESSAGE_COST_EDITS`: 60 messages a second
/// with an edit each, one for each picture that a viewer shows.
pub const THROTTLED_EDIT_RATE: AllowanceRate = AllowanceRate { per_second: 120.0, burst: 120.0 };
/// Requests about a session, or about none, while a hand moves a view.
pub const THROTTLED_REQUEST_RATE: AllowanceRate = AllowanceRate { per_second: 200.0, burst: 200.0 };
/// Decoding of uploaded scenes while a hand moves a view, in seconds of the thread that decodes; the next upload waits.
pub const THROTTLED_UPLOAD_RATE: AllowanceRate = AllowanceRate { per_second: 0.25, burst: 1.0 };
/// An upload counts for so many seconds of decoding at most: the next one waits for 2 s and no longer.
pub const MAX_UPLOAD_CHARGE: Duration = Duration::from_millis(500);
/// A message or a request counts for so many edits besides those that it has: its way to the session, its commit, and all who are told.
pub const MESSAGE_COST_EDITS: f64 = 1.0;
/// How often a drag is solved for one step while others change what it depends on. After that it is refused.
pub const MAX_SOLVE_TRIES: u32 = 4;
/// Scenes that are being sent to the server; each may take hundreds of megabytes of its disk.
pub const MAX_UPLOADS: usize = 32;
/// Sessions that are open at once; the others rest in the store.
pub const MAX_ROOMS: usize = 64;
/// Clients in one session.
pub const MAX_CLIENTS: usize = 64;
/// Bytes that the renderer keeps, over all sessions: a quarter of `MemoryMax` in `deploy/bendylights.service`, which
/// leaves as much for eight stills with their files, and half for scenes and documents. With more in use at once, what
/// was used longest ago is made again when it is next needed.
pub const MAX_RENDER_BYTES: u64 = 4 << 30;
/// Decoded scenes kept besides those in use.
pub const MAX_CACHED_SCENES: usize = 4;

/// Bytes of requests and answers in memory over all clients: bodies with what is made of them, and answers and messages of more
/// than `SMALL_BYTES` until they are taken. The largest picture, 4096 x 4096 in EXR, has 256 MiB.
pub const MAX_BYTES_IN_FLIGHT: usize = 320 << 20;
/// Of that, bodies'.
pub const MAX_BODY_BYTES_IN_FLIGHT: usize = MAX_BYTES_IN_FLIGHT / 2;
/// Bytes up to which bodies and answers are not on that account: 640 connections with one each have 40 MiB, and nobody is refused
/// a small one for others' large ones.
pub const SMALL_BYTES: usize = 64 << 10;
/// A body counts for so many times its bytes: what its JSON becomes takes a few times as much.
pub const BODY_COST: usize = 4;
/// Bytes from which on an answer is compressed: shorter ones fit into a packet or two anyway.
pub const COMPRESSED_FROM_BYTES: u16 = 1 << 10;
/// Bytes of a page of a log that is sent as it is read, but for a single record that has more.
pub const LOG_PAGE_BYTES: usize = 128 << 10;
/// Bytes of a request's head, and of an answer that one connection takes from its pages at a time.
pub const MAX_HEAD_BYTES: usize = 64 << 10;

/// Bytes of a control message. A light with the most control points takes less than a tenth.
pub const MAX_MESSAGE_BYTES: usize = 1 << 20;
/// Bytes of a request's JSON.
pub const MAX_BODY_BYTES: usize = 8 << 20;
/// Edits in one request.
pub const MAX_EDITS: usize = 1_000;
/// Edits in one request that are one step: a session's task carries them out at once, as many as those of a tick.
pub const MAX_GROUP_EDITS: usize = MAX_TICK_MESSAGES;
/// Drags of features that a request asks of at most; one takes some milliseconds.
pub const MAX_DRAGS: usize = 1_000;
/// Records in one answer of the log.
pub const MAX_LOG_RECORDS: usize = 10_000;
/// Nodes of a scene that are listed.
pub const MAX_NODES_LISTED: usize = 10_000;
/// Bytes of names that clients choose: of actors, operations and gestures.
pub const MAX_LABEL_BYTES: usize = 128;

/// Pixels along a side of a picture, streamed or for HTTP.
pub const MAX_VIEW_SIDE: u32 = protocol::RenderLimits::HTTP.max_side;
/// Pixels of a view that is streamed, enough for 3840 x 2160; the renderer keeps 44 bytes for each, its
/// session 4.
pub const MAX_VIEW_PIXELS: u32 = 1 << 23;

/// Pixels of all views of an actor that move at once, one of 3840 x 2160 or as many smaller ones; past that they are drawn smaller.
pub const MAX_MOVING_PIXELS: u64 = 3840 * 2160;

/// Messages that wait for a session's task; senders wait past that.
pub const ROOM_QUEUE: usize = 1_024;
/// A client's messages by which it edits that are not carried out yet; most of them wait for one of its drags to be solved. With
/// more its socket is not read.
pub const MAX_QUEUED_MESSAGES: usize = 64;
/// Messages that a session's task carries out before it commits their edits together, and as many edits of programs'
/// requests.
pub const MAX_TICK_MESSAGES: usize = 256;
/// Changes of a tick's records, past which the rest of programs' requests waits for the next tick. One may hold a light with
/// the most control points before and after: 33 KB in memory, and as much again as JSON several times.
pub const MAX_TICK_CHANGES: usize = 2_048;
/// Control messages that wait for one client. One with more is behind: it is told what it missed when it has taken them.
pub const CONTROL_QUEUE: usize = 1_024;
/// Bytes of control messages that wait for one client, as above; a single message may have more.
pub const CONTROL_BYTES: usize = 8 << 20;
/// Bytes of them past which nothing more is read from the client: what waits for it may be its own answers, which nobody shares.
pub const READ_PAUSE_BYTES: usize = 1 << 20;
/// Bytes of a message that are given to its socket at a time: what a socket that takes nothing holds for itself.
pub const FRAGMENT_BYTES: usize = 64 << 10;
/// Bytes that a socket reads at a time.
pub const SOCKET_READ_BYTES: usize = 16 << 10;
/// Pictures, or tiles of a lossless one, that wait for one client: its window. With more its socket has stalled, and it is sent none.
pub const FRAME_QUEUE: usize = stream::MAX_FRAMES_IN_FLIGHT;
/// Pictures that are on their way to the renderer; senders wait past that.
pub const RENDER_QUEUE: usize = 256;
/// Pictures that have a place in line: one of each view and each still, so that nobody's waits for another's to be taken.
pub const MAX_PICTURES: usize = MAX_SOCKETS + MAX_STILLS;
/// How long a picture of those who only watch keeps its content while it waits, though that changes, for each client of its
/// session: so a session asks for a thousand pictures a second at most.
pub const STALE_TIME_PER_CLIENT: Duration = Duration::from_millis(1);
/// Lines of pictures that wait for the disk of the trace; more are left out and counted.
pub const TRACE_QUEUE: usize = 1_024;
/// Commits that wait for the disk; senders wait past that.
pub const COMMIT_QUEUE: usize = 64;
/// Records after which a session gets a new checkpoint, once they have as many bytes as the last one: replaying so many takes
/// well under a second, and checkpoints take no more of the disk's time than records.
pub const CHECKPOINT_AFTER_RECORDS: u64 = 1_000;
/// Bytes of records in full after which it gets one too, or four times its last one's where that is more.
pub const CHECKPOINT_AFTER_BYTES: u64 = 4 << 20;
/// Connections to the store that are kept for reading.
pub const MAX_READERS: usize = 8;
/// Records that a returning client is sent at most; one that missed more is sent the document.
pub const MAX_CATCH_UP_RECORDS: u64 = 1_000;
/// Bytes of those records, but for a single one. The document's text is shared, theirs is not.
pub const MAX_CATCH_UP_BYTES: usize = 1 << 20;

/// How long a request's head may take to come, and a connection to ask for something.
pub const HEADERS_TIMEOUT: Duration = Duration::from_secs(30);
/// How long a request's body may rest without a byte.
pub const BODY_IDLE_TIMEOUT: Duration = Duration::from_secs(30);
/// How long a turn of a connection that has not shown the token lasts at least: with 16 of them there are 640 requests a second,
/// which take some hundredths of one core.
pub const MIN_ANONYMOUS_PERMIT_TIME: Duration = Duration::from_millis(25);
/// How long a body of more than `SMALL_BYTES` may take to come: 8 MiB by 70 KB a second.
pub const LARGE_BODY_TIMEOUT: Duration = Duration::from_mins(2);
/// Bytes a second by which a message or a large answer has to be taken, after `SEND_TIMEOUT`; the connection of one that is taken
/// slower ends. A document of 16 MiB may take 18 minutes.
pub const MIN_DELIVERY_BYTES_PER_SECOND: u64 = 16 << 10;
/// How long a socket may take to say hello.
pub const HELLO_TIMEOUT: Duration = Duration::from_secs(10);
/// How often a client is asked for a sign of life.
pub const PING_EVERY: Duration = Duration::from_secs(20);
/// How long a client may give none.
pub const CLIENT_SILENCE_TIMEOUT: Duration = Duration::from_mins(1);
/// How long a connection may take nothing of what it is sent.
pub const SEND_TIMEOUT: Duration = Duration::from_secs(30);
/// How long a client may take to close its side.
pub const CLOSE_TIMEOUT: Duration = Duration::from_secs(1);
/// How long a session stays open without clients and requests.
pub const SESSION_IDLE_TIMEOUT: Duration = Duration::from_mins(1);
/// How often leases of gestures are looked at.
pub const LEASE_CHECK_EVERY: Duration = Duration::from_secs(1);
/// How often a stalled socket and a client that is behind are looked at.
pub const STALLED_CHECK_EVERY: Duration = Duration::from_millis(100);
/// How often it is looked whether a client has taken the tile of a lossless picture that it was sent, to send the next.
pub const TILES_CHECK_EVERY: Duration = Duration::from_millis(4);
/// How often all are told where the others' cameras are, at most.
pub const PRESENCE_EVERY: Duration = Duration::from_millis(100);
/// Share of the renderer's time that views at rest get while something moves, and stills while anything else goes on.
pub const SETTLING_TIME_SHARE: f64 = 0.1;
/// Share of the renderer's time that the views of those who only watch get while a hand drags.
pub const WATCHED_TIME_SHARE: f64 = 0.3;
/// How long after its last edit, or move of its camera, a client's view is that of a hand.
pub const INTERACTIVE_FOR: Duration = Duration::from_secs(1);
/// How long after its last picture something still moves: a drag's next one is asked for when the last is shown.
pub const MOVING_FOR: Duration = Duration::from_millis(300);
/// How long a picture that a hand moves is worked on at once where several clients' hands move. A switch costs caches, and a wait
/// for the device: beside 250 views that another drags, one has .34 of its frames with turns of 8 ms by wgpu and .47 natively, with
/// 16 ms .51 and .58. Longest gaps are no longer; with 24 ms they are.
pub const MOVING_TURN: Duration = Duration::from_millis(16);
/// How long another picture is worked on at once while something moves. A tenth of the time of a drag whose pictures take a sixth of
/// a second is more.
pub const TURN_WHILE_MOVING: Duration = Duration::from_millis(10);
/// How long after its last picture a client counts as one of several that draw: then no moving picture is drawn in one go.
pub const SHARED_FOR: Duration = Duration::from_secs(10);
/// Pixels above which a moving picture of one of several clients is drawn in tiles: more take longer than a turn even for one light.
pub const LARGE_PICTURE_PIXELS: u32 = 1_500_000;
/// Pixels above which a moving picture is encoded as work in the background where several clients' move; so many take some 17 ms of a core.
pub const LARGE_ENCODE_PIXELS: u32 = 1 << 19;
/// Turns after which a moving picture is drawn to its end, however long that takes: what is kept of it from turn to turn may have been
/// evicted each time.
pub const MAX_MOVING_TURNS: u32 = 1_000;
/// The same at rest: so long may something that begins to move have to wait.
pub const MAX_TURN: Duration = Duration::from_millis(50);
/// How long the end of a server waits for the last lines of its trace.
pub const TRACE_FLUSH_TIMEOUT: Duration = Duration::from_secs(1);
/// How long a server that is asked to stop may take.
pub const DRAIN_TIMEOUT: Duration = Duration::from_secs(10);
/// When clients should try again after that.
pub const RETRY_AFTER: Duration = Duration::from_secs(1);
