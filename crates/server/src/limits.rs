//! Limits of the server. A request beyond one is refused with its number.

use std::time::Duration;

use crate::allowances::AllowanceRate;

/// Greatest number of connections, including sockets. More wait until one ends.
pub const MAX_CONNECTIONS: usize = 640;
/// Sizes of the system's receive and send buffer of a connection in bytes. The system counts twice as many. By itself
/// it grows them to tens of megabytes, so a few hundred connections that neither read nor are read would leave no
/// buffers for others. At a round trip of a tenth of a second a connection gets 2.5 and 5 MB per second.
pub const RECEIVE_BUFFER_BYTES: usize = 256 << 10;
pub const SEND_BUFFER_BYTES: usize = 512 << 10;
/// Greatest number of connections that have not shown the token, by a request or a hello. Above it the oldest is
/// closed.
pub const MAX_ANONYMOUS_CONNECTIONS: usize = 128;
/// Greatest number of anonymous requests answered at once, for liveness checks and for everything else separately.
/// Others wait for a permit.
pub const MAX_ANONYMOUS_REQUESTS: usize = 16;
/// Bytes per second of answers per permit for anonymous requests. Together 16 MiB per second load the page a hundred
/// times.
pub const ANONYMOUS_BYTES_PER_SECOND: u64 = 1 << 20;
/// Greatest number of sockets that have said hello.
pub const MAX_SOCKETS: usize = 256;
/// Greatest number of HTTP requests carried out at once. A request counts after it has arrived completely.
pub const MAX_REQUESTS: usize = 64;
/// Greatest number of pictures for HTTP that are rendered or wait for the renderer.
pub const MAX_STILLS: usize = 8;
/// Greatest size of the pictures of a request before compression, in bytes. A beauty of 4096 x 4096 takes all of it.
pub const MAX_PICTURE_BYTES: usize = 256 << 20;
/// Greatest number of probes and picks that trace rays at once, for about a millisecond each. Others wait.
pub const MAX_PROBES: usize = 4;
/// Greatest number of drags of features that are being solved or wait, each with a thread: one per socket and per HTTP
/// request.
pub const MAX_SOLVES: usize = MAX_SOCKETS + MAX_REQUESTS;
/// Number of counted steps up to which a solve is short. Short solves run before long ones. So many steps take about 20
/// ms, and most solves need fewer.
pub const SHORT_SOLVE_STEPS: u64 = 20_000_000;
/// Solver time that a client may use for short solves before its solves count as long, in seconds of a core: about 25
/// drags per second of a usual light. Long solves take no more time if the CPU is otherwise idle.
pub const SHORT_SOLVE_RATE: AllowanceRate = AllowanceRate { per_second: 0.25, burst: 0.5 };
/// Messages that a socket may send while a user of another client moves a view. The rate is several times that of a
/// user who acknowledges frames and drags or orbits.
pub const THROTTLED_MESSAGE_RATE: AllowanceRate = AllowanceRate { per_second: 400.0, burst: 400.0 };
/// Edits that a session, and an actor, may make while a user of another client moves a view. With `MESSAGE_COST_EDITS`
/// they allow 60 messages per second with an edit each, one per shown picture.
pub const THROTTLED_EDIT_RATE: AllowanceRate = AllowanceRate { per_second: 120.0, burst: 120.0 };
/// Requests about a session, or about no session, that are let through while a user moves a view.
pub const THROTTLED_REQUEST_RATE: AllowanceRate = AllowanceRate { per_second: 200.0, burst: 200.0 };
/// Seconds that the server may spend on decoding uploaded scenes while a user moves a view. Further uploads wait.
pub const THROTTLED_UPLOAD_RATE: AllowanceRate = AllowanceRate { per_second: 0.25, burst: 1.0 };
/// Greatest time that an upload is charged, in seconds of decoding. So the next upload waits for at most 2 s.
pub const MAX_UPLOAD_CHARGE: Duration = Duration::from_millis(500);
/// Cost of a message or request in edits, besides its own edits: its delivery to the session, its commit and its
/// broadcast.
pub const MESSAGE_COST_EDITS: f64 = 1.0;
/// Number of times that one step of a drag is solved while other clients change its inputs. After that the step is
/// refused.
pub const MAX_SOLVE_TRIES: u32 = 4;
/// Greatest number of scenes being uploaded. Each may take hundreds of megabytes of disk.
pub const MAX_UPLOADS: usize = 32;
/// Greatest number of open sessions. The others are only in the store.
pub const MAX_ROOMS: usize = 64;
/// Greatest number of clients in a session.
pub const MAX_CLIENTS: usize = 64;
/// Memory budget of the renderer in bytes, over all sessions: a quarter of `MemoryMax` in `deploy/bendylights.service`.
/// Another quarter is for eight stills with their files, and half for scenes and documents. Above the budget the least
/// recently used data is evicted, and made again when it is needed.
pub const MAX_RENDER_BYTES: u64 = 4 << 30;
/// Number of decoded scenes cached besides those in use.
pub const MAX_CACHED_SCENES: usize = 4;

/// Bytes of requests and answers in memory over all clients: bodies with the data made from them, and answers and
/// messages of more than `SMALL_BYTES` until they are taken. The largest picture, 4096 x 4096 in EXR, has 256 MiB.
pub const MAX_BYTES_IN_FLIGHT: usize = 320 << 20;
/// Part of `MAX_BYTES_IN_FLIGHT` that bodies may use.
pub const MAX_BODY_BYTES_IN_FLIGHT: usize = MAX_BYTES_IN_FLIGHT / 2;
/// Size up to which bodies and answers are not counted in `MAX_BYTES_IN_FLIGHT`. 640 connections with one such body
/// or answer each have 40 MiB. So no client is refused a small one because of large ones of others.
pub const SMALL_BYTES: usize = 64 << 10;
/// Factor for the bytes of a body: the data made from its JSON takes a few times as much.
pub const BODY_COST: usize = 4;
/// Size from which an answer is compressed. A shorter one fits into a packet or two anyway.
pub const COMPRESSED_FROM_BYTES: u64 = 1 << 10;
/// Size of a page of a log that is sent while it is read, in bytes, except for a single larger record.
pub const LOG_PAGE_BYTES: usize = 128 << 10;
/// Greatest size of a request's head in bytes. A connection takes at most as many bytes of an answer from its stream at
/// a time.
pub const MAX_HEAD_BYTES: usize = 64 << 10;

/// Greatest size of a control message in bytes. A light with the most control points takes less than a tenth.
pub const MAX_MESSAGE_BYTES: usize = 1 << 20;
/// Greatest size of a request's JSON in bytes.
pub const MAX_BODY_BYTES: usize = 8 << 20;
/// Greatest number of edits in a request.
pub const MAX_EDITS: usize = 1_000;
/// Greatest number of edits in a request that make one step. A session's task carries them out in one tick.
pub const MAX_GROUP_EDITS: usize = MAX_TICK_MESSAGES;
/// Greatest number of feature drags in a request. Each takes some milliseconds.
pub const MAX_DRAGS: usize = 1_000;
/// Most drags of a request whose alternatives are listed. Each is drawn up to five times.
pub const MAX_DRAGS_WITH_ALTERNATIVES: usize = 16;
/// Greatest number of records in an answer of the log.
pub const MAX_LOG_RECORDS: usize = 10_000;
/// Greatest number of listed nodes of a scene.
pub const MAX_NODES_LISTED: usize = 10_000;
/// Greatest size of names that clients choose in bytes: of actors, operations and gestures.
pub const MAX_LABEL_BYTES: usize = 128;

/// Greatest side of a picture in pixels, streamed or for HTTP.
pub const MAX_VIEW_SIDE: u32 = protocol::RenderLimits::HTTP.max_side;
/// Greatest number of pixels of a streamed view, enough for 3840 x 2160. For each the renderer keeps 44 bytes and the
/// session 4.
pub const MAX_VIEW_PIXELS: u32 = 1 << 23;

/// Greatest number of pixels of an actor's views that move at once: one of 3840 x 2160, or as many smaller ones. Above
/// it they are drawn smaller.
pub const MAX_MOVING_PIXELS: u64 = 3840 * 2160;

/// Greatest number of messages that wait for a session's task. Above it senders wait.
pub const ROOM_QUEUE: usize = 1_024;
/// Greatest number of a client's editing messages that are not carried out yet. Most of them wait for the solve of one
/// of the client's drags. Above this number the server stops reading from the socket.
pub const MAX_QUEUED_MESSAGES: usize = 64;
/// Greatest number of messages that a session's task carries out before it commits their edits together, and of edits
/// of programs' requests.
pub const MAX_TICK_MESSAGES: usize = 256;
/// Number of changes in a tick's records above which the rest of programs' requests waits for the next tick. A change
/// can hold a light with the most control points before and after: 33 KB in memory, and as much again as JSON several
/// times.
pub const MAX_TICK_CHANGES: usize = 2_048;
/// Greatest number of control messages that wait for a client. Above it the server stops sending changes to the client
/// one by one. Once the client has taken its messages, it gets the current state instead.
pub const CONTROL_QUEUE: usize = 1_024;
/// Greatest size of the control messages that wait for a client, in bytes. A single message may be larger.
pub const CONTROL_BYTES: usize = 8 << 20;
/// Size of a client's waiting control messages above which the server does not read the client's requests. Answers to
/// the client count too, and are not shared with other clients.
pub const READ_PAUSE_BYTES: usize = 1 << 20;
/// Bytes of a message given to its socket at a time: the memory held by a socket that takes nothing.
pub const FRAGMENT_BYTES: usize = 64 << 10;
/// Bytes that a socket reads at a time.
pub const SOCKET_READ_BYTES: usize = 16 << 10;
/// Greatest number of pictures, or tiles of a lossless picture, that wait for a client: its window. A socket with that
/// many has stalled and gets no more.
pub const FRAME_QUEUE: usize = stream::MAX_FRAMES_IN_FLIGHT;
/// Greatest number of pictures on their way to the renderer. Above it senders wait.
pub const RENDER_QUEUE: usize = 256;
/// Greatest number of queued pictures: one per view and per still, so that no picture waits for another one to be
/// queued.
pub const MAX_PICTURES: usize = MAX_SOCKETS + MAX_STILLS;
/// Time per client of the session during which a queued picture of a watching client keeps its content although the
/// document changes. So a session requests at most a thousand pictures per second.
pub const STALE_TIME_PER_CLIENT: Duration = Duration::from_millis(1);
/// Greatest number of trace lines that wait for the disk. More are left out and counted.
pub const TRACE_QUEUE: usize = 1_024;
/// Greatest number of commits that wait for the disk. Above it senders wait.
pub const COMMIT_QUEUE: usize = 64;
/// Number of records after which a session gets a new checkpoint, once they have as many bytes as the last one.
/// Replaying that many takes well under a second, and checkpoints take no more of the disk's time than records.
pub const CHECKPOINT_AFTER_RECORDS: u64 = 1_000;
/// Bytes of complete records after which a session gets a new checkpoint, or four times the size of its last one if
/// that is more.
pub const CHECKPOINT_AFTER_BYTES: u64 = 4 << 20;
/// Number of connections to the store kept for reading.
pub const MAX_READERS: usize = 8;
/// Greatest number of records sent to a returning client. If it missed more, it gets the document.
pub const MAX_CATCH_UP_RECORDS: u64 = 1_000;
/// Greatest size in bytes of the records sent to a returning client, except for a single larger one. The text of the
/// document is shared between clients, the text of these records is not.
pub const MAX_CATCH_UP_BYTES: usize = 1 << 20;

/// Time within which a request's head has to arrive, and within which a connection has to send a request.
pub const HEADERS_TIMEOUT: Duration = Duration::from_secs(30);
/// Greatest time between two parts of a request's body.
pub const BODY_IDLE_TIMEOUT: Duration = Duration::from_secs(30);
/// Least time of a permit for anonymous requests. With 16 of them there are 640 requests per second, which take some
/// hundredths of a core.
pub const MIN_ANONYMOUS_PERMIT_TIME: Duration = Duration::from_millis(25);
/// Time within which a body of more than `SMALL_BYTES` has to arrive: 8 MiB at 70 KB per second.
pub const LARGE_BODY_TIMEOUT: Duration = Duration::from_mins(2);
/// Least rate at which a client has to take a message or a large answer after `SEND_TIMEOUT`, in bytes per second. A
/// slower connection is closed. A document of 16 MiB may take 18 minutes.
pub const MIN_DELIVERY_BYTES_PER_SECOND: u64 = 16 << 10;
/// Time within which a socket has to say hello.
pub const HELLO_TIMEOUT: Duration = Duration::from_secs(10);
/// Interval of pings to a client.
pub const PING_EVERY: Duration = Duration::from_secs(20);
/// Greatest silence of a client.
pub const CLIENT_SILENCE_TIMEOUT: Duration = Duration::from_mins(1);
/// Greatest time during which a connection takes none of its data.
pub const SEND_TIMEOUT: Duration = Duration::from_secs(30);
/// Time within which a client has to close its side.
pub const CLOSE_TIMEOUT: Duration = Duration::from_secs(1);
/// Time for which a session stays open without clients and requests.
pub const SESSION_IDLE_TIMEOUT: Duration = Duration::from_mins(1);
/// Interval of checks of gestures' leases.
pub const LEASE_CHECK_EVERY: Duration = Duration::from_secs(1);
/// Interval of checks of stalled sockets and of clients that fell behind.
pub const STALLED_CHECK_EVERY: Duration = Duration::from_millis(100);
/// Interval of checks for a client that has taken a tile of a lossless picture and can get the next.
pub const TILES_CHECK_EVERY: Duration = Duration::from_millis(4);
/// Least interval of broadcasts of presence, which includes cameras.
pub const PRESENCE_EVERY: Duration = Duration::from_millis(100);
/// Share of the renderer's time for views at rest while something moves, and for stills while anything else is drawn.
pub const SETTLING_TIME_SHARE: f64 = 0.1;
/// Share of the renderer's time for the views of watching clients while a user drags.
pub const WATCHED_TIME_SHARE: f64 = 0.3;
/// Time after its last edit or move of its camera during which a client's view counts as interactive.
pub const INTERACTIVE_FOR: Duration = Duration::from_secs(1);
/// Time after its last picture during which a view counts as moving. In a drag the client requests the next picture
/// when the last one is shown.
pub const MOVING_FOR: Duration = Duration::from_millis(300);
/// Length of a slice of drawing time for a picture that a user moves, while several users move something. Changing to
/// another picture loses cache contents and waits for the device. Beside 250 views of a drag by another client, a view
/// gets 0.34 of its frames with slices of 8 ms by wgpu and 0.47 natively, and 0.51 and 0.58 with 16 ms. With 16 ms the
/// longest gaps are as long as with 8 ms. With 24 ms they are longer.
pub const MOVING_TURN: Duration = Duration::from_millis(16);
/// Length of a slice of drawing time for any other picture while something moves: less than a tenth of a frame that
/// takes a sixth of a second.
pub const TURN_WHILE_MOVING: Duration = Duration::from_millis(10);
/// Time after its last picture during which a client counts as one of several that draw. While there are several, no
/// moving picture is drawn in one slice.
pub const SHARED_FOR: Duration = Duration::from_secs(10);
/// Number of pixels above which a moving picture is drawn in tiles while several clients draw. A larger picture takes
/// longer than a slice even with one light.
pub const LARGE_PICTURE_PIXELS: u32 = 1_500_000;
/// Number of pixels above which a moving picture is encoded as background work while several clients' views move. That
/// many take about 17 ms of a core.
pub const LARGE_ENCODE_PIXELS: u32 = 1 << 19;
/// Number of slices after which a moving picture is drawn to its end in one slice. Its cached layers may have been
/// evicted between slices.
pub const MAX_MOVING_TURNS: u32 = 1_000;
/// Length of a slice of drawing time while nothing moves. A view that starts to move may wait for that long.
pub const MAX_TURN: Duration = Duration::from_millis(50);
/// Time that a stopping server waits for the last lines of its trace.
pub const TRACE_FLUSH_TIMEOUT: Duration = Duration::from_secs(1);
/// Time within which a server has to stop.
pub const DRAIN_TIMEOUT: Duration = Duration::from_secs(10);
/// Time after which clients should connect again.
pub const RETRY_AFTER: Duration = Duration::from_secs(1);
