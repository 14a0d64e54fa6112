// Sentences of the server, which start small as Rust's errors do.

/** `text` with a capital first letter; a quotation or a number that it starts with stays as it is. */
export const sentence = (text: string): string => text.replace(/^\p{Ll}/u, (letter) => letter.toUpperCase());
