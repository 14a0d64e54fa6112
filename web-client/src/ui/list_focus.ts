// The keyboard's focus in lists whose rows go.

/** Before the row of `button` goes: gives the focus to the same button of a row beside it, or to what adds rows. */
export function focusBeside(button: HTMLElement): void {
  const row = button.closest("li");
  const beside = row?.nextElementSibling ?? row?.previousElementSibling;
  const next =
    beside?.querySelector<HTMLElement>(".item-action") ?? row?.closest("section")?.querySelector("button");
  next?.focus();
}
