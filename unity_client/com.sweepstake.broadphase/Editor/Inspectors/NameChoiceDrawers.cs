#nullable enable
using System.Collections.Generic;
using Sweepstake.Unity;
using UnityEditor;
using UnityEditor.UIElements;
using UnityEngine.UIElements;

namespace Sweepstake.Editor
{
    [CustomPropertyDrawer(typeof(BackendNameAttribute))]
    internal sealed class BackendNameDrawer : NameChoiceDrawer
    {
        protected override IReadOnlyList<string> Names() => SweepstakeLibrary.Backends;
    }

    [CustomPropertyDrawer(typeof(MotionSceneNameAttribute))]
    internal sealed class MotionSceneNameDrawer : NameChoiceDrawer
    {
        protected override IReadOnlyList<string> Names() => SweepstakeLibrary.Scenes;
    }

    /// <summary>Offers names of the library; without it, and for a value that is none of them, the text itself.</summary>
    internal abstract class NameChoiceDrawer : PropertyDrawer
    {
        protected abstract IReadOnlyList<string> Names();

        public override VisualElement CreatePropertyGUI(SerializedProperty property)
        {
            List<string>? choices = SweepstakeLibrary.FindProblem() == null ? ChoicesFor(property.stringValue) : null;
            BindableElement field = choices == null
                ? (BindableElement)new TextField(property.displayName)
                : new DropdownField(property.displayName, choices, choices.IndexOf(property.stringValue));
            field.tooltip = property.tooltip;
            field.BindProperty(property);
            return field;
        }

        internal List<string> ChoicesFor(string value)
        {
            var choices = new List<string>(Names());
            if (!choices.Contains(value))
                choices.Insert(0, value);
            return choices;
        }
    }
}
