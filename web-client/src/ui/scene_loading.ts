// The scene of the page's session, in place of the one that it has.

import { fitScene } from "./fitting";
import { canEdit, type Page } from "./page";

/** Why no scene can be opened in the session now, if none can. */
export const sceneHindrance = (page: Page): string | null =>
  canEdit(page) ? null : "Not connected: no scene can be opened now. Try again once the page is connected.";

/** Loads a scene that the server has, and looks at it as its first camera does; a sentence says why not. */
export async function loadScene(page: Page, scene: string): Promise<string | null> {
  if (!canEdit(page)) return "The server has it, but this page is not connected: load it once it is.";
  const { session } = page;
  session.edit({ type: "loadScene", scene }, () => {
    const [first] = session.document.value.cameras;
    if (first === undefined) fitScene(page);
    else session.viewer.jump(first.camera);
  });
  return null;
}
