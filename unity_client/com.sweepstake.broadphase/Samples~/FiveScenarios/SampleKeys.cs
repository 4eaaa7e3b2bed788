#nullable enable
#if SWEEPSTAKE_INPUT_SYSTEM && ENABLE_INPUT_SYSTEM
using UnityEngine.InputSystem;
#else
using UnityEngine;
#endif

namespace Sweepstake.Samples
{
    /// <summary>The keys of the sample, for either input system.</summary>
    internal static class SampleKeys
    {
#if SWEEPSTAKE_INPUT_SYSTEM && ENABLE_INPUT_SYSTEM
        /// <summary>The digit key pressed in this frame, 1 to 5; 0 if none was pressed.</summary>
        internal static int Digit()
        {
            Keyboard? keyboard = Keyboard.current;
            for (int digit = 1; keyboard != null && digit <= 5; ++digit)
            {
                if (keyboard[Key.Digit1 + (digit - 1)].wasPressedThisFrame)
                    return digit;
            }
            return 0;
        }

        internal static bool Mode => Keyboard.current != null && Keyboard.current[Key.M].wasPressedThisFrame;
        internal static bool Backend => Keyboard.current != null && Keyboard.current[Key.B].wasPressedThisFrame;
        internal static bool More => Keyboard.current != null && Keyboard.current[Key.UpArrow].wasPressedThisFrame;
        internal static bool Fewer => Keyboard.current != null && Keyboard.current[Key.DownArrow].wasPressedThisFrame;
#else
        /// <summary>The digit key pressed in this frame, 1 to 5; 0 if none was pressed.</summary>
        internal static int Digit()
        {
            for (int digit = 1; digit <= 5; ++digit)
            {
                if (Input.GetKeyDown(KeyCode.Alpha0 + digit))
                    return digit;
            }
            return 0;
        }

        internal static bool Mode => Input.GetKeyDown(KeyCode.M);
        internal static bool Backend => Input.GetKeyDown(KeyCode.B);
        internal static bool More => Input.GetKeyDown(KeyCode.UpArrow);
        internal static bool Fewer => Input.GetKeyDown(KeyCode.DownArrow);
#endif
    }
}
