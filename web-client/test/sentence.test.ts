import { expect, test } from "vitest";

import { sentence } from "../src/ui/sentence";

test("a sentence starts with a capital, and what it quotes stays as it is", () => {
  for (const [said, shown] of [
    ["the light would fold", "The light would fold"],
    ["écran", "Écran"],
    ["“key” is held by Ada", "“key” is held by Ada"],
    ["`loadScene` needs a scene", "`loadScene` needs a scene"],
    ["2 points", "2 points"],
    ["Light 1", "Light 1"],
    ["", ""],
  ] as const) {
    expect(sentence(said)).toBe(shown);
  }
});
