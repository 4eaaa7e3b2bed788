import { expect, it } from 'vitest';
import { fileName, visible } from './name';

it('does not change names of visible characters', () => {
  expect(visible("Ölfaß – 'scène' <b>&amp;</b> 日本 🎮")).toBe("Ölfaß – 'scène' <b>&amp;</b> 日本 🎮");
});

it('shows the codes of invisible characters and of characters that reorder a line', () => {
  expect(visible('a\u202egnp.exe')).toBe('a⟨U+202E⟩gnp.exe');
  expect(visible('a\u200bb\ufeffc\u0007\u2028')).toBe('a⟨U+200B⟩b⟨U+FEFF⟩c⟨U+0007⟩⟨U+2028⟩');
  expect(visible('\u2066x\u2069\u{e0041}\u3164')).toBe('⟨U+2066⟩x⟨U+2069⟩⟨U+E0041⟩⟨U+3164⟩');
});

it('shows the codes of characters that make two names look the same', () => {
  expect(visible('arena\ufe0f')).toBe('arena⟨U+FE0F⟩');
  expect(visible('a\u00a0b\u3000c d')).toBe('a⟨U+00A0⟩b⟨U+3000⟩c d');
  expect(visible('\uffff\u{e0100}\u180b')).toBe('⟨U+FFFF⟩⟨U+E0100⟩⟨U+180B⟩');
});

it('makes file names without a path to another folder', () => {
  expect(fileName('../../etc', 'a/b\\c')).toBe('etc_a-b-c');
  expect(fileName('..')).toBe('sweepstake');
});
