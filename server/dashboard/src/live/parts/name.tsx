// A name from a game, shown safely: isolated from the surrounding text direction, with invisible characters replaced by their codes.

export function Name({ text, unknown = 'unknown' }: { text: string; unknown?: string }) {
  if (text === '') return <span class="soft">{unknown}</span>;
  const shown = visible(text);
  return <bdi class="name" title={shown}>{shown}</bdi>;
}

const HIDDEN = /[\p{C}\p{Zl}\p{Zp}\p{Default_Ignorable_Code_Point}\u2800]|[^\P{Zs} ]/gu;

export const visible = (name: string) =>
  name.replace(HIDDEN, (character) => `⟨U+${character.codePointAt(0)!.toString(16).toUpperCase().padStart(4, '0')}⟩`);

export const fileName = (...names: string[]) =>
  names.map((name) => name.replace(/[^\p{L}\p{N}.-]+/gu, '-').replace(/^[.-]+|-+$/g, '').slice(0, 60)).filter(Boolean).join('_') || 'sweepstake';
