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
    }

    public class GUIUtility
    {
        public static string systemCopyBuffer { get; set; } = "";
    }

    public class GUI
    {
        public static GUISkin skin { get; } = new GUISkin();
    }

#if ENABLE_LEGACY_INPUT_MANAGER
    public enum KeyCode
    {
        Alpha0 = 48,
        B = 98,
        M = 109,
        UpArrow = 273,
        DownArrow = 274,
    }

    public class Input
    {
        public static bool GetKeyDown(KeyCode key) => false;
    }
#endif
}
