// The theme that the user chose.
import { effect, signal } from '@preact/signals';
import { remember, remembered } from './remembered';

export const THEMES = ['auto', 'light', 'dark'] as const;
export const theme = signal(THEMES.find((each) => each === remembered('theme')) ?? 'auto');

effect(() => {
  const chosen = theme.value === 'auto' ? undefined : theme.value;
  if (chosen) document.documentElement.dataset.theme = chosen;
  else delete document.documentElement.dataset.theme;
  remember('theme', chosen);
});
