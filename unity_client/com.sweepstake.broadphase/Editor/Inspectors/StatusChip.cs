#nullable enable
using Sweepstake.Unity;
using UnityEngine.UIElements;

namespace Sweepstake.Editor
{
    /// <summary>A label that shows the state of a manager as a coloured word.</summary>
    internal sealed class StatusChip : Label
    {
        private const string Class = "sweepstake-chip";
        private string tone = Class + "--none";

        internal StatusChip()
        {
            AddToClassList(Class);
            Show(SweepstakeState.Stopped);
        }

        internal void Show(SweepstakeState state)
        {
            text = StatusText.Chip(state);
            RemoveFromClassList(tone);
            tone = state switch
            {
                SweepstakeState.Online or SweepstakeState.Embedded => Class + "--good",
                SweepstakeState.Connecting or SweepstakeState.Offline => Class + "--warning",
                SweepstakeState.Refused or SweepstakeState.Failed => Class + "--bad",
                _ => Class + "--none",
            };
            AddToClassList(tone);
        }
    }
}
