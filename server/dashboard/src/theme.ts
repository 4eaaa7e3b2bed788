// The theme that the user chose.
import { remember, remembered } from './remembered';

export const THEMES = ['auto', 'light', 'dark'] as const;
export type Theme = (typeof THEMES)[number];

function show(theme: Theme): void {
  if (theme === 'auto') delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
}

export function chooseTheme(theme: Theme): void {
  show(theme);
  remember('theme', theme);
}

// Shows the theme that was chosen last, and returns it.
export function keptTheme(): Theme {
  const theme = THEMES.find((each) => each === remembered('theme')) ?? 'auto';
  show(theme);
  return theme;
}
