#nullable enable
using System;
using System.Collections.Generic;
using System.Linq;
using UnityEngine;
#if SWEEPSTAKE_INPUT_SYSTEM && ENABLE_INPUT_SYSTEM
using UnityEngine.InputSystem;
#endif

namespace Sweepstake.Samples
{
    /// <summary>A button of the panel, and the key that does the same.</summary>
    internal sealed class PanelCommand
    {
        internal const char NoKey = '\0';

        private readonly char key;
        private readonly Func<string> label;
        private readonly Func<bool>? isChosen;

        /// <param name="key">A capital letter, a digit from 1 to 9, or NoKey.</param>
        /// <param name="isChosen">Whether the button is marked; null: never.</param>
        internal PanelCommand(char key, Func<string> label, Action run, Func<bool>? isChosen = null)
        {
            this.key = key;
            this.label = label;
            this.isChosen = isChosen;
            Run = run;
        }

        internal Action Run { get; }
        internal string Text => (isChosen != null && isChosen() ? "● " : "") + (key == NoKey ? "" : $"[{key}] ") + label();

#if SWEEPSTAKE_INPUT_SYSTEM && ENABLE_INPUT_SYSTEM
        /// <summary>Whether the key was pressed in this frame.</summary>
        internal bool IsPressed => key != NoKey && Keyboard.current != null &&
            Keyboard.current[key >= 'A' ? Key.A + (key - 'A') : Key.Digit1 + (key - '1')].wasPressedThisFrame;
#else
        /// <summary>Whether the key was pressed in this frame. Unity's codes of letters and digits are those of their small ASCII characters.</summary>
        internal bool IsPressed => key != NoKey && Input.GetKeyDown((KeyCode)char.ToLowerInvariant(key));
#endif
    }

    /// <summary>Text, buttons and a table in a corner of the screen, with the keys of the buttons for either input system.</summary>
    internal sealed class Panel
    {
        private const float Margin = 8;
        private const float WidthInFonts = 42;
        private const float ColumnInFonts = 6.5f;

        private readonly List<PanelCommand[]> rows = new List<PanelCommand[]>();
        private readonly int fontSize;
        private GUIStyle? area;
        private GUIStyle? button;
        private GUIStyle? label;

        internal Panel(int fontSize)
        {
            this.fontSize = fontSize;
        }

        internal string Text { get; set; } = "";

        internal void AddRow(IEnumerable<PanelCommand> commands) => rows.Add(commands.ToArray());

        /// <summary>Runs the commands whose keys were pressed in this frame.</summary>
        internal void ReadKeys()
        {
            foreach (PanelCommand[] row in rows)
            {
                foreach (PanelCommand command in row)
                {
                    if (command.IsPressed)
                        command.Run();
                }
            }
        }

        /// <summary>Call it from OnGUI.</summary>
        internal void Draw(IReadOnlyList<string[]> table)
        {
            area ??= new GUIStyle(GUI.skin.box);
            button ??= new GUIStyle(GUI.skin.button) { fontSize = fontSize };
            label ??= new GUIStyle(GUI.skin.label) { fontSize = fontSize, wordWrap = true };
            GUILayout.BeginArea(new Rect(Margin, Margin, Mathf.Min(WidthInFonts * fontSize, Screen.width - 2 * Margin), Screen.height - 2 * Margin), area);
            foreach (PanelCommand[] row in rows)
            {
                GUILayout.BeginHorizontal();
                foreach (PanelCommand command in row)
                {
                    if (GUILayout.Button(command.Text, button))
                        command.Run();
                }
                GUILayout.EndHorizontal();
            }
#if !ENABLE_LEGACY_INPUT_MANAGER
            GUILayout.Label("The buttons do not react to the mouse with the Input System package alone. Press the keys in brackets.", label);
#endif
            GUILayout.Label(Text, label);
            foreach (string[] row in table)
            {
                GUILayout.BeginHorizontal();
                foreach (string cell in row)
                    GUILayout.Label(cell, label, GUILayout.Width(ColumnInFonts * fontSize));
                GUILayout.EndHorizontal();
            }
            GUILayout.EndArea();
        }
    }
}
