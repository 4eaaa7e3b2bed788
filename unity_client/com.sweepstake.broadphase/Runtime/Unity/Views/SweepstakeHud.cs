#nullable enable
using System.Text;
using UnityEngine;

namespace Sweepstake.Unity
{
    /// <summary>
    /// Shows the state of a manager in a corner of the screen, also in builds and with either input system. A few times a second its text
    /// is updated, which allocates memory. Remove the HUD if the game must not allocate.
    /// </summary>
    [AddComponentMenu("Sweepstake/Sweepstake HUD")]
    [DisallowMultipleComponent]
    [DocumentationPage("components.md")]
    public sealed class SweepstakeHud : MonoBehaviour
    {
        private const float Margin = 8;

        [Tooltip("The manager whose state is shown. None: the one on the same object, or the first enabled one.")]
        [SerializeField] private SweepstakeManager? manager;
        [Tooltip("Updates of the text per second.")]
        [SerializeField, Range(1, 10)] private int refreshesPerSecond = 4;
        [Tooltip("The size of the font, in points of the screen.")]
        [SerializeField, Range(8, 48)] private int fontSize = 14;

        private readonly StringBuilder text = new StringBuilder(512);
        private readonly GUIContent content = new GUIContent();
        private GUIStyle? style;
        private float sinceSeconds;
        private int frames;

        /// <summary>The displayed text.</summary>
        public string Text => content.text;

        private void Awake()
        {
            useGUILayout = false;
            if (manager == null)
                manager = GetComponent<SweepstakeManager>();
        }

        private void Update()
        {
            sinceSeconds += Time.unscaledDeltaTime;
            ++frames;
            if (sinceSeconds * refreshesPerSecond < 1)
                return;
            Refresh(frames / sinceSeconds);
            sinceSeconds = 0;
            frames = 0;
        }

        private void OnGUI()
        {
            if (Event.current.type != EventType.Repaint || content.text.Length == 0)
                return;
            style ??= new GUIStyle(GUI.skin.box) { alignment = TextAnchor.UpperLeft, wordWrap = false };
            style.fontSize = fontSize;
            Vector2 size = style.CalcSize(content);
            style.Draw(new Rect(Margin, Margin, Mathf.Min(size.x, Screen.width - 2 * Margin), size.y), content, false, false, false, false);
        }

        private void Refresh(double fps)
        {
            SweepstakeManager? shown = manager != null ? manager : SweepstakeManager.Enabled.Count > 0 ? SweepstakeManager.Enabled[0] : null;
            text.Clear();
            if (shown != null)
                StatusText.Append(text, shown, fps);
            content.text = text.ToString();
        }
    }
}
