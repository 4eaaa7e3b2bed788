// Names come from games, and some are hostile: written to reorder the line they are in, or to look like another name. What has no
// shape of its own is shown by its number.
const HIDDEN = /[\p{Cc}\p{Cf}\p{Cs}\p{Co}\p{Zl}\p{Zp}\u115f\u1160\u3164\uffa0\u034f\u2800]/gu;

export const visible = (name: string) =>
  name.replace(HIDDEN, (character) => `⟨U+${character.codePointAt(0)!.toString(16).toUpperCase().padStart(4, '0')}⟩`);

// A file name of these names.
export const fileName = (...names: string[]) =>
  names.map((name) => name.replace(/[^\p{L}\p{N}.-]+/gu, '-').replace(/^[.-]+|-+$/g, '').slice(0, 60)).filter(Boolean).join('_') || 'sweepstake';
