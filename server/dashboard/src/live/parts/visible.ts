// Names come from games, and some are hostile: written to reorder the line they are in, or to look like another name. What has no
// shape of its own, and every blank but the ordinary one, is shown by its number.
const HIDDEN = /[\p{C}\p{Zl}\p{Zp}\p{Default_Ignorable_Code_Point}\u2800]|[^\P{Zs} ]/gu;

export const visible = (name: string) =>
  name.replace(HIDDEN, (character) => `⟨U+${character.codePointAt(0)!.toString(16).toUpperCase().padStart(4, '0')}⟩`);

// A file name of these names.
export const fileName = (...names: string[]) =>
  names.map((name) => name.replace(/[^\p{L}\p{N}.-]+/gu, '-').replace(/^[.-]+|-+$/g, '').slice(0, 60)).filter(Boolean).join('_') || 'sweepstake';
