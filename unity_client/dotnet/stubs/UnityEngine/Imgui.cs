using System.Collections.Generic;

namespace UnityEngine
{
    public enum EventType
    {
        MouseDown = 0,
        Repaint = 7,
        Layout = 8,
    }

    public sealed class Event
    {
        public static Event current { get; set; } = new Event();
        public EventType type { get; set; } = EventType.Repaint;
    }

    public enum TextAnchor
    {
        UpperLeft,
    }

    public class GUIContent
    {
        public GUIContent()
        {
        }

        public GUIContent(string text)
        {
            this.text = text;
        }

        public string text { get; set; } = "";
    }

    public sealed class GUIStyle
    {
        public GUIStyle()
        {
        }

        public GUIStyle(GUIStyle other)
        {
        }

        public TextAnchor alignment { get; set; }
        public bool wordWrap { get; set; }
        public int fontSize { get; set; }

        public Vector2 CalcSize(GUIContent content) => new Vector2(100, 20);

        public void Draw(Rect position, GUIContent content, bool isHover, bool isActive, bool on, bool hasKeyboardFocus)
        {
        }
    }

    public sealed class GUISkin
    {
        public GUIStyle box { get; } = new GUIStyle();
        public GUIStyle button { get; } = new GUIStyle();
        public GUIStyle label { get; } = new GUIStyle();
    }

    public class GUIUtility
    {
        public static string systemCopyBuffer { get; set; } = "";
    }

    public class GUI
    {
        public static GUISkin skin { get; } = new GUISkin();
    }

    public sealed class GUILayoutOption
    {
        internal GUILayoutOption()
        {
        }
    }

    public class GUILayout
    {
        /// <summary>For tests: the texts of the latest area, and a part of the text of the button that counts as pressed.</summary>
        internal static List<string> Texts { get; } = new List<string>();
        internal static string Pressed { get; set; } = "";

        public static void BeginArea(Rect screenRect, GUIStyle style) => Texts.Clear();

        public static void EndArea()
        {
        }

        public static void BeginHorizontal(params GUILayoutOption[] options)
        {
        }

        public static void EndHorizontal()
        {
        }

        public static void Label(string text, GUIStyle style, params GUILayoutOption[] options) => Texts.Add(text);

        public static bool Button(string text, GUIStyle style, params GUILayoutOption[] options)
        {
            Texts.Add(text);
            return Pressed.Length > 0 && text.Contains(Pressed);
        }

        public static GUILayoutOption Width(float width) => new GUILayoutOption();
    }

#if ENABLE_LEGACY_INPUT_MANAGER
    public enum KeyCode
    {
        None = 0,
    }

    public class Input
    {
        /// <summary>For tests: the key that counts as pressed in each frame.</summary>
        internal static KeyCode Pressed { get; set; }

        public static bool GetKeyDown(KeyCode key) => key != KeyCode.None && key == Pressed;
    }
#endif
}
