// A name from a game, shown safely: isolated from the surrounding text direction, with invisible characters replaced by their codes.
import { visible } from './visible';

export function Name({ text, unknown = 'unknown' }: { text: string; unknown?: string }) {
  if (text === '') return <span class="soft">{unknown}</span>;
  const shown = visible(text);
  return <bdi class="name" title={shown}>{shown}</bdi>;
}
