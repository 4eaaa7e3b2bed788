namespace UnityEngine.InputSystem.Controls
{
    public class ButtonControl
    {
        public bool wasPressedThisFrame => false;
    }

    public class KeyControl : ButtonControl
    {
    }
}

namespace UnityEngine.InputSystem
{
    public enum Key
    {
        B = 16,
        M = 27,
        Digit1 = 41,
        UpArrow = 63,
        DownArrow = 64,
    }

    public class Keyboard
    {
        public static Keyboard current => null;
        public Controls.KeyControl this[Key key] => new Controls.KeyControl();
    }
}
