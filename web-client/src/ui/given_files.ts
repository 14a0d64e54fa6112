// Files that a person picks or drops, with their paths.

import type { Given } from "../core/gltf_pack";

/** Files of a folder past which it is no scene's: somebody has dropped a disk. */
const MOST_FILES = 20_000;

/** Input of the latest dialog. A browser may collect an input that nothing refers to while its dialog is open, and no
 * files arrive. */
let input: HTMLInputElement;

/** Lets a person pick files, or with `folder` a folder with all that is in it. */
export function pickFiles(folder: boolean, picked: (given: Given<File>[]) => void): void {
  input = document.createElement("input");
  input.type = "file";
  input.multiple = true;
  input.webkitdirectory = folder;
  input.onchange = () => {
    const files = [...(input.files ?? [])];
    picked(files.map((file) => ({ path: file.webkitRelativePath || file.name, file })));
  };
  input.click();
}

/** True if a dragged thing contains files. */
export const hasFiles = ({ dataTransfer }: DragEvent): boolean =>
  dataTransfer?.types.includes("Files") === true;

/** The files that are dropped, and those in folders; `null` where they are too many. To be called before the event ends. */
export async function droppedFiles({ dataTransfer }: DragEvent): Promise<Given<File>[] | null> {
  const items = [...(dataTransfer?.items ?? [])].filter(({ kind }) => kind === "file");
  // The items are gone once the event has ended.
  const roots = items.map((item) => ({ entry: item.webkitGetAsEntry(), file: item.getAsFile() }));
  const given: Given<File>[] = [];
  const waiting = roots.flatMap(({ entry, file }) => {
    if (entry === null && file !== null) given.push({ path: file.name, file });
    return entry === null ? [] : [entry];
  });
  for (let entry = waiting.pop(); entry !== undefined; entry = waiting.pop()) {
    if (given.length + waiting.length > MOST_FILES) return null;
    if (isFolder(entry)) waiting.push(...(await entriesOf(entry)));
    else
      given.push({
        path: entry.fullPath.replace(/^\//, ""),
        file: await fileOf(entry as FileSystemFileEntry),
      });
  }
  return given;
}

const isFolder = (entry: FileSystemEntry): entry is FileSystemDirectoryEntry => entry.isDirectory;

const fileOf = (entry: FileSystemFileEntry): Promise<File> =>
  new Promise((found, failed) => entry.file(found, failed));

/** A folder tells of some entries at a time, and of none once it has told of all. */
async function entriesOf(folder: FileSystemDirectoryEntry): Promise<FileSystemEntry[]> {
  const reader = folder.createReader();
  const all: FileSystemEntry[] = [];
  for (;;) {
    const some = await new Promise<FileSystemEntry[]>((found, failed) => reader.readEntries(found, failed));
    if (some.length === 0) return all;
    all.push(...some);
  }
}
