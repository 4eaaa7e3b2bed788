// Names come from games and may be hostile: they may reorder the line that contains them, or look like another name. Characters
// without a visible shape, and all spaces except U+0020, are shown by their code.
const HIDDEN = /[\p{C}\p{Zl}\p{Zp}\p{Default_Ignorable_Code_Point}\u2800]|[^\P{Zs} ]/gu;

export const visible = (name: string) =>
  name.replace(HIDDEN, (character) => `⟨U+${character.codePointAt(0)!.toString(16).toUpperCase().padStart(4, '0')}⟩`);

// Returns a file name made from these names.
export const fileName = (...names: string[]) =>
  names.map((name) => name.replace(/[^\p{L}\p{N}.-]+/gu, '-').replace(/^[.-]+|-+$/g, '').slice(0, 60)).filter(Boolean).join('_') || 'sweepstake';
