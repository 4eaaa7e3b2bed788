using System;
using System.Collections.Generic;

namespace UnityEngine.UIElements
{
    public enum DisplayStyle
    {
        Flex,
        None,
    }

    public struct StyleEnum<T>
        where T : struct, IConvertible
    {
        public T value { get; set; }

        public static implicit operator StyleEnum<T>(T v) => new StyleEnum<T> { value = v };
    }

    public struct StyleColor
    {
        public static implicit operator StyleColor(Color v) => default;
    }

    public interface IStyle
    {
        StyleEnum<DisplayStyle> display { get; set; }
        StyleColor color { get; set; }
    }

    public class StyleSheet : ScriptableObject
    {
    }

    public struct VisualElementStyleSheetSet
    {
        public void Add(StyleSheet styleSheet)
        {
        }
    }

    public interface IVisualElementScheduledItem
    {
        IVisualElementScheduledItem Every(long intervalMs);
    }

    public interface IVisualElementScheduler
    {
        IVisualElementScheduledItem Execute(Action updateEvent);
    }

    public class VisualElement
    {
        private readonly List<VisualElement> children = new List<VisualElement>();
        private readonly HashSet<string> classes = new HashSet<string>();

        public Rect contentRect => new Rect(0, 0, 300, 96);
        public string tooltip { get; set; } = "";
        public IStyle style { get; } = new Style();
        public VisualElementStyleSheetSet styleSheets => default;
        public IVisualElementScheduler schedule { get; } = new Scheduler();
        public Action<MeshGenerationContext> generateVisualContent { get; set; }

        public void Add(VisualElement child) => children.Add(child);
        public void Clear() => children.Clear();
        public IEnumerable<VisualElement> Children() => children;
        public void AddToClassList(string className) => classes.Add(className);
        public void RemoveFromClassList(string className) => classes.Remove(className);
        public bool ClassListContains(string cls) => classes.Contains(cls);
        public void MarkDirtyRepaint() => generateVisualContent?.Invoke(new MeshGenerationContext());

        private sealed class Style : IStyle
        {
            public StyleEnum<DisplayStyle> display { get; set; }
            public StyleColor color { get; set; }
        }

        private sealed class Scheduler : IVisualElementScheduler, IVisualElementScheduledItem
        {
            public IVisualElementScheduledItem Execute(Action updateEvent) => this;
            public IVisualElementScheduledItem Every(long intervalMs) => this;
        }
    }

    public class MeshGenerationContext
    {
        internal MeshGenerationContext()
        {
        }

        public Painter2D painter2D { get; } = new Painter2D();
    }

    public enum FillRule
    {
        NonZero,
        OddEven,
    }

    public class Painter2D
    {
        /// <summary>For tests: the number of points with coordinates that are not finite.</summary>
        internal static int BadPointCount { get; set; }

        public Color strokeColor { get; set; }
        public Color fillColor { get; set; }
        public float lineWidth { get; set; }

        public void BeginPath()
        {
        }

        public void ClosePath()
        {
        }

        public void MoveTo(Vector2 pos) => LineTo(pos);
        public void LineTo(Vector2 pos) => BadPointCount += float.IsFinite(pos.x) && float.IsFinite(pos.y) ? 0 : 1;

        public void Stroke()
        {
        }

        public void Fill(FillRule fillRule = FillRule.NonZero)
        {
        }
    }

    public interface IBindable
    {
    }

    public class BindableElement : VisualElement, IBindable
    {
    }

    public class TextElement : BindableElement
    {
        public virtual string text { get; set; } = "";
    }

    public class Label : TextElement
    {
        public Label()
        {
        }

        public Label(string text)
        {
            this.text = text;
        }
    }

    public class Button : TextElement
    {
        public Button()
        {
        }

        private readonly Action onClick;

        public Button(Action clickEvent)
        {
            onClick = clickEvent;
        }

        /// <summary>For tests.</summary>
        internal void Click() => onClick();
    }

    public class ScrollView : VisualElement
    {
    }

    public enum HelpBoxMessageType
    {
        None,
        Info,
        Warning,
        Error,
    }

    public class HelpBox : VisualElement
    {
        public HelpBox()
        {
        }

        public HelpBox(string text, HelpBoxMessageType messageType)
        {
            this.text = text;
            this.messageType = messageType;
        }

        public string text { get; set; } = "";
        public HelpBoxMessageType messageType { get; set; }
    }

    public delegate void EventCallback<in TEventType>(TEventType evt);

    public class ChangeEvent<T>
    {
        public T newValue { get; protected set; }

        internal static ChangeEvent<T> To(T value) => new ChangeEvent<T> { newValue = value };
    }

    public interface INotifyValueChanged<T>
    {
        T value { get; set; }
        void SetValueWithoutNotify(T newValue);
    }

    public static class INotifyValueChangedExtensions
    {
        public static bool RegisterValueChangedCallback<T>(this INotifyValueChanged<T> control, EventCallback<ChangeEvent<T>> callback)
        {
            ((BaseField<T>)control).Changed += callback;
            return true;
        }
    }

    public abstract class BaseField<TValueType> : BindableElement, INotifyValueChanged<TValueType>
    {
        private TValueType held;

        protected BaseField(string label, VisualElement visualInput)
        {
        }

        internal event EventCallback<ChangeEvent<TValueType>> Changed;

        public virtual TValueType value
        {
            get => held;
            set
            {
                if (EqualityComparer<TValueType>.Default.Equals(held, value))
                    return;
                SetValueWithoutNotify(value);
                Changed?.Invoke(ChangeEvent<TValueType>.To(value));
            }
        }

        public virtual void SetValueWithoutNotify(TValueType newValue) => held = newValue;
    }

    public class TextField : BaseField<string>
    {
        public TextField(string label)
            : base(label, null)
        {
        }
    }

    public class DropdownField : BaseField<string>
    {
        public DropdownField()
            : base(null, null)
        {
        }

        public DropdownField(
            string label, List<string> choices, int defaultIndex, Func<string, string> formatSelectedValueCallback = null, Func<string, string> formatListItemCallback = null)
            : base(label, null)
        {
            this.choices = choices;
        }

        public virtual List<string> choices { get; set; }
    }
}
