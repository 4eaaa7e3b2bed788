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
        A = 15,
        Digit1 = 41,
    }

    public class Keyboard
    {
        public static Keyboard current => null;
        public Controls.KeyControl this[Key key] => new Controls.KeyControl();
    }
}
