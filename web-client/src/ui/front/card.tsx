// A session in the list: its picture, what it is called, its last change, who is in it.

import type { ComponentChildren } from "preact";
import { useEffect, useLayoutEffect, useRef } from "preact/hooks";

import type { SessionEntry } from "../../core/protocol";
import { changeText, clippable, peopleText } from "../../core/session_list";
import { addressOf } from "../address";
import { sentence } from "../sentence";
import { useFront } from "./front";

interface CardProps {
  session: SessionEntry;
  /** Its buttons. */
  children: ComponentChildren;
}

export function Card({ session, children }: CardProps) {
  const { renaming, focused, nowMs } = useFront();
  const link = useRef<HTMLAnchorElement>(null);
  const { name, title, people } = session;
  const isRenamed = renaming.value === name;
  const isFocused = focused.value === name;
  // Before the next key, which is for this card.
  useLayoutEffect(() => {
    if (!isFocused || isRenamed) return;
    link.current?.focus();
    focused.value = null;
  }, [isFocused, isRenamed, focused]);
  const who = peopleText(people);
  const changed = sentence(changeText(session, nowMs.value));
  return (
    <li class="card" data-session={name}>
      <a
        class="card-link"
        ref={link}
        href={addressOf(name)}
        aria-label={[title, who && `${who} in it`, changed].filter(Boolean).join(", ")}
      >
        <Picture session={session} />
        {!isRenamed && <ClippedName name={title} of={name} />}
        {who !== "" && (
          <>
            {/* The text of the link, with a space here, must be words of its accessible name, in order. */}{" "}
            <span class="card-people" title={people.join(", ")}>
              <span class="dot" />
              <span class="clipped">{who}</span>
            </span>
          </>
        )}
      </a>
      {isRenamed && <Title session={session} />}
      <p class="card-changed clipped" title={changed}>
        {changed}
      </p>
      <div class="card-actions">{children}</div>
    </li>
  );
}

/** A name whose middle is clipped where it has no room. */
function ClippedName({ name, of }: { name: string; of: string }) {
  const [start, end] = clippable(name);
  return (
    <span class="card-title" title={name === of ? name : `${name} (${of} in addresses)`}>
      <span class="clipped">{start}</span>
      <span>{end}</span>
    </span>
  );
}

/** Its title while that is typed. */
function Title({ session }: { session: SessionEntry }) {
  const { renaming, rename, focused } = useFront();
  const input = useRef<HTMLInputElement>(null);
  // Before the next key: what is typed at once is its name.
  useLayoutEffect(() => input.current?.select(), []);
  const finish = (typed: string) => {
    // It goes away by a key, and then by losing the focus.
    if (renaming.value !== session.name) return;
    renaming.value = null;
    const title = typed.trim();
    if (title !== "" && title !== session.title) void rename(session, title);
  };
  return (
    <input
      class="text"
      ref={input}
      aria-label={`New name of ${session.title}`}
      // Not `value`, to which a list that comes meanwhile would set it back.
      defaultValue={session.title}
      maxLength={120}
      onKeyDown={(event) => {
        event.stopPropagation();
        if (event.key !== "Escape" && event.key !== "Enter") return;
        finish(event.key === "Enter" ? event.currentTarget.value : "");
        focused.value = session.name;
      }}
      onBlur={(event) => finish(event.currentTarget.value)}
    />
  );
}

function Picture({ session }: { session: SessionEntry }) {
  const { thumbnails } = useFront();
  const frame = useRef<HTMLSpanElement>(null);
  const isSeen = useRef(false);
  const latest = useRef(session);
  latest.current = session;
  useEffect(() => {
    if (frame.current === null) return undefined;
    const observer = new IntersectionObserver((entries) => {
      isSeen.current = entries.at(-1)?.isIntersecting ?? false;
      if (isSeen.current) thumbnails.show(latest.current);
      else thumbnails.hide(latest.current.name);
    });
    observer.observe(frame.current);
    return () => {
      observer.disconnect();
      thumbnails.hide(latest.current.name);
    };
  }, [thumbnails]);
  // The list came anew.
  useEffect(() => {
    if (isSeen.current) thumbnails.show(session);
  }, [session, thumbnails]);
  const shown = thumbnails.of(session.name).value;
  const words = session.seq === 0 ? "Empty" : "No picture";
  return (
    <span class="card-picture" ref={frame} data-picture={shown.kind}>
      {shown.kind === "shown" && <img src={shown.url} alt="" />}
      {(shown.kind === "failed" || session.seq === 0) && (
        <span class="card-blank" title={shown.kind === "failed" ? sentence(shown.why) : undefined}>
          {words}
        </span>
      )}
    </span>
  );
}
