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

    /// <summary>A text field with a drop-down of the library's names that fills it; without the library, only the text field.</summary>
    internal abstract class NameChoiceDrawer : PropertyDrawer
    {
        protected abstract IReadOnlyList<string> Names();

        public override VisualElement CreatePropertyGUI(SerializedProperty property)
        {
            var text = new TextField(property.displayName) { tooltip = property.tooltip };
            text.AddToClassList("sweepstake-choice-text");
            text.BindProperty(property);
            var row = new VisualElement();
            PackagePaths.AddStyle(row);
            row.AddToClassList("sweepstake-choice");
            row.Add(text);
            if (SweepstakeLibrary.FindProblem() == null)
                row.Add(ChoiceFor(text));
            return row;
        }

        private DropdownField ChoiceFor(TextField text)
        {
            var choice = new DropdownField { choices = new List<string>(Names()), tooltip = "The names that the library knows." };
            choice.AddToClassList("sweepstake-choice-names");
            choice.RegisterValueChangedCallback(change =>
            {
                if (string.IsNullOrEmpty(change.newValue))
                    return;
                text.value = change.newValue;
                // Clear the selection, so that each name can be selected again.
                choice.SetValueWithoutNotify("");
            });
            return choice;
        }
    }
}
