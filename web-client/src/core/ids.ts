// Numbers that name things, for readers: to the wire they are all numbers.

/** A light of the document, never used twice in a session. */
export type LightId = number;
/** A camera of the document, never used twice in a session. */
export type CameraId = number;
/** A connection to the session. */
export type ClientId = number;
