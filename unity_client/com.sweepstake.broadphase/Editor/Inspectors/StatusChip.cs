#nullable enable
using Sweepstake.Unity;
using UnityEngine.UIElements;

namespace Sweepstake.Editor
{
    /// <summary>A label that shows the state of a manager as a coloured word.</summary>
    internal sealed class StatusChip : Label
    {
        private const string Class = "sweepstake-chip";
        private string tone = "";

        internal StatusChip()
        {
            AddToClassList(Class);
            Show(SweepstakeState.Stopped);
        }

        internal void Show(SweepstakeState state)
        {
            text = StatusText.Chip(state);
            if (tone.Length > 0)
                RemoveFromClassList(tone);
            tone = ToneOf(state);
            if (tone.Length > 0)
                AddToClassList(tone);
        }

        private static string ToneOf(SweepstakeState state) => state switch
        {
            SweepstakeState.Online => Class + "--good",
            SweepstakeState.Embedded => Class + "--good",
            SweepstakeState.Connecting => Class + "--warning",
            SweepstakeState.Offline => Class + "--warning",
            SweepstakeState.Refused => Class + "--bad",
            SweepstakeState.Failed => Class + "--bad",
            _ => "",
        };
    }
}
